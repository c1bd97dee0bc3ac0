/* SPDX-License-Identifier: GPL-2.0-or-later */
/* All protocols: their fields, expert items, subtrees and preferences.
 * Made by generate.py from protocols.toml, fields.toml and experts.toml: edit there. */
/* clang-format off */

#include "protocol/fields.h"

#include "items.h"

#define MOST_PORT 65535

static const true_false_string texts_sis_parameter_product_specific = {"P, product-specific", "S, standard"};
static const unit_name_string unit_sis_list_actual = {" byte", " bytes"};
static const unit_name_string unit_sis_list_maximum = {" byte", " bytes"};
static const true_false_string texts_sis_control_number = {"Present", "Not present"};
static const true_false_string texts_sis_control_reaction = {"Reaction telegram", "Command telegram"};
static const unit_name_string unit_sis_sequence_length = {" byte", " bytes"};
static const unit_name_string unit_sis_flash_length = {" byte", " bytes"};
static const true_false_string texts_sis_transmission = {"last", "current, more follows"};
static const unit_name_string unit_sis_bus_baud = {" Bd", NULL};
static const unit_name_string unit_3964r_length = {" byte", " bytes"};
static const unit_name_string unit_arcnet7f_list_actual = {" byte", " bytes"};
static const unit_name_string unit_arcnet7f_list_maximum = {" byte", " bytes"};
static const unit_name_string unit_synax_pieces_length = {" byte", " bytes"};
static const true_false_string texts_synaxpk_word_read = {"Read", "Write"};
static const true_false_string texts_synaxobj_status_bus = {"No failure", "After a failure of the bus"};
static const enum_val_t choices_sis_edition[] = {
    {"IF02", "IF02 (SIS definition of 2004, IndraDrive)", 0},
    {"ECODRIVE03", "ECODRIVE03 (FGP-01VRS)", 1},
    {NULL, NULL, 0},
};
static const enum_val_t choices_sis_tza_from[] = {
    {"unknown", "Unknown", 0},
    {"end", "The end of the character before: the pause alone", 1},
    {"start", "The start of the character before: the whole interval", 2},
    {NULL, NULL, 0},
};
static const enum_val_t choices_synaxpk_layout[] = {
    {"synax", "SYNAX200", 0},
    {"indradrive", "IndraDrive", 1},
    {NULL, NULL, 0},
};
static const enum_val_t choices_synaxpk_direction[] = {
    {"guess", "As the packet says: sent, received", 0},
    {"master", "Master", 1},
    {"slave", "Slave", 2},
    {NULL, NULL, 0},
};

int proto_sertap = -1;
int proto_sis = -1;
int proto_3964r = -1;
int proto_rk512i = -1;
int proto_arcnet7f = -1;
int proto_synax = -1;
int proto_synaxpk = -1;
int proto_synaxobj = -1;
int proto_synaxpcp = -1;
int proto_synaxpd = -1;
int proto_sisascii = -1;

int ett_sertap = -1;
int ett_sertap_format = -1;
int ett_sertap_characters = -1;
int ett_sertap_character = -1;
int ett_sis = -1;
int ett_sis_control = -1;
int ett_sis_parameter_control = -1;
int ett_sis_data_status = -1;
int ett_sis_whole = -1;
int ett_sis_element = -1;
int ett_sis_sequence = -1;
int ett_sis_piece = -1;
int ett_sis_timing = -1;
int ett_sis_ident = -1;
int ett_sis_attribute = -1;
int ett_sis_list = -1;
int ett_sis_value = -1;
int ett_3964r = -1;
int ett_rk512i = -1;
int ett_rk512i_whole = -1;
int ett_arcnet7f = -1;
int ett_synax = -1;
int ett_synax_info = -1;
int ett_synax_pieces = -1;
int ett_synax_piece = -1;
int ett_synaxpk = -1;
int ett_synaxpk_word = -1;
int ett_synaxpk_raw = -1;
int ett_synaxobj = -1;
int ett_synaxobj_word = -1;
int ett_synaxpcp = -1;
int ett_synaxpcp_error = -1;
int ett_synaxpd = -1;
int ett_synaxpd_value = -1;
int ett_sisascii = -1;

int pref_sis_edition = 0;
compat_bool pref_sis_clc_as_sercos = FALSE;
compat_bool pref_sis_ecodrive_phases = FALSE;
unsigned pref_sis_tza_ms = 0;
int pref_sis_tza_from = 0;
unsigned pref_sis_trs_ms = 0;
compat_bool pref_sis_tcp_heuristic = TRUE;
compat_bool pref_sis_udp_heuristic = FALSE;
unsigned pref_3964r_zvz_ms = 220;
unsigned pref_3964r_qvz_ms = 2000;
int pref_synaxpk_layout = 0;
int pref_synaxpk_direction = 0;
range_t *pref_synaxpd_ports = NULL;
compat_bool pref_synaxpd_swap_bytes = FALSE;
compat_bool pref_synaxpd_swap_words = FALSE;

int hf_sertap_version = -1;
int hf_sertap_header_length = -1;
int hf_sertap_type = -1;
int hf_sertap_line = -1;
int hf_sertap_baud = -1;
int hf_sertap_format = -1;
int hf_sertap_format_data_bits = -1;
int hf_sertap_format_parity = -1;
int hf_sertap_format_stop = -1;
int hf_sertap_framing = -1;
int hf_sertap_uncertainty = -1;
int hf_sertap_count = -1;
int hf_sertap_event = -1;
int hf_sertap_text = -1;
int hf_sertap_data = -1;
int hf_sertap_character = -1;
int hf_sertap_interval = -1;
int hf_sertap_interval_max = -1;
int hf_sertap_flags = -1;
int hf_sertap_same_read = -1;
int hf_sertap_error_character = -1;
int hf_sertap_error_break = -1;
int hf_sertap_error_lost = -1;
int hf_sertap_error_unlocated = -1;
int hf_sertap_interval_unknown = -1;
int hf_sertap_interval_saturated = -1;
int hf_sis_data = -1;
int hf_sis_raw = -1;
int hf_sis_value_number = -1;
int hf_sis_value_bit = -1;
int hf_sis_parameter = -1;
int hf_sis_parameter_name = -1;
int hf_sis_parameter_unit = -1;
int hf_sis_parameter_minimum = -1;
int hf_sis_parameter_maximum = -1;
int hf_sis_parameter_type = -1;
int hf_sis_parameter_product_specific = -1;
int hf_sis_parameter_set = -1;
int hf_sis_parameter_number = -1;
int hf_sis_value = -1;
int hf_sis_element_name = -1;
int hf_sis_element_unit = -1;
int hf_sis_attribute = -1;
int hf_sis_attribute_factor = -1;
int hf_sis_attribute_length = -1;
int hf_sis_attribute_command = -1;
int hf_sis_attribute_format = -1;
int hf_sis_attribute_decimals = -1;
int hf_sis_attribute_protected_2 = -1;
int hf_sis_attribute_protected_3 = -1;
int hf_sis_attribute_protected_4 = -1;
int hf_sis_list_actual = -1;
int hf_sis_list_maximum = -1;
int hf_sis_access = -1;
int hf_sis_packed = -1;
int hf_sis_text = -1;
int hf_sis_element_length = -1;
int hf_sis_stream = -1;
int hf_sis_reaction_in = -1;
int hf_sis_command_in = -1;
int hf_sis_reaction_time = -1;
int hf_sis_reaction_time_ms = -1;
int hf_sis_repeat_of = -1;
int hf_sis_unanswered_before = -1;
int hf_sis_next_command_in = -1;
int hf_sis_answered_in = -1;
int hf_sis_routed_from = -1;
int hf_sis_service = -1;
int hf_sis_status = -1;
int hf_sis_device = -1;
int hf_sis_subservice = -1;
int hf_sis_error = -1;
int hf_sis_phase = -1;
int hf_sis_init_baud_mask = -1;
int hf_sis_start = -1;
int hf_sis_checksum = -1;
int hf_sis_checksum_status = -1;
int hf_sis_length = -1;
int hf_sis_length_repeat = -1;
int hf_sis_control = -1;
int hf_sis_control_subaddresses = -1;
int hf_sis_control_number = -1;
int hf_sis_control_reaction = -1;
int hf_sis_control_reserved = -1;
int hf_sis_control_warning = -1;
int hf_sis_control_error = -1;
int hf_sis_control_reserved_bits = -1;
int hf_sis_control_status = -1;
int hf_sis_sender = -1;
int hf_sis_receiver = -1;
int hf_sis_subaddress = -1;
int hf_sis_number = -1;
int hf_sis_talker = -1;
int hf_sis_listener = -1;
int hf_sis_station = -1;
int hf_sis_sequence = -1;
int hf_sis_sequence_piece = -1;
int hf_sis_sequence_overlap = -1;
int hf_sis_sequence_overlap_conflict = -1;
int hf_sis_sequence_multiple_tails = -1;
int hf_sis_sequence_too_long = -1;
int hf_sis_sequence_error = -1;
int hf_sis_sequence_count = -1;
int hf_sis_sequence_whole_in = -1;
int hf_sis_sequence_length = -1;
int hf_sis_sequence_begun_in = -1;
int hf_sis_canceled_service = -1;
int hf_sis_flash_address = -1;
int hf_sis_flash_length = -1;
int hf_sis_flash_target = -1;
int hf_sis_flash_device_type = -1;
int hf_sis_flash_crc32 = -1;
int hf_sis_version = -1;
int hf_sis_firmware = -1;
int hf_sis_type_key = -1;
int hf_sis_init_time = -1;
int hf_sis_init_test_time = -1;
int hf_sis_parameter_control = -1;
int hf_sis_parameter_control_reserved = -1;
int hf_sis_element = -1;
int hf_sis_transmission = -1;
int hf_sis_list_offset = -1;
int hf_sis_list_length = -1;
int hf_sis_data_status = -1;
int hf_sis_data_status_set = -1;
int hf_sis_data_status_enabled = -1;
int hf_sis_data_status_not_executed = -1;
int hf_sis_data_status_impossible = -1;
int hf_sis_data_status_invalid = -1;
int hf_sis_phase_switch_in = -1;
int hf_sis_phase_switch_time = -1;
int hf_sis_silence_before = -1;
int hf_sis_silence_before_ms = -1;
int hf_sis_tza_interval_max = -1;
int hf_sis_tza_interval_max_ms = -1;
int hf_sis_tza_position = -1;
int hf_sis_tza_limit = -1;
int hf_sis_tza_set_in = -1;
int hf_sis_tza_verdict = -1;
int hf_sis_trs_limit = -1;
int hf_sis_trs_set_in = -1;
int hf_sis_trs_verdict = -1;
int hf_sis_twm_wait = -1;
int hf_sis_tmas_before_in = -1;
int hf_sis_tmas_cycle = -1;
int hf_sis_tmas_limit = -1;
int hf_sis_tmas_set_in = -1;
int hf_sis_tmas_verdict = -1;
int hf_sis_bus_baud = -1;
int hf_sis_bus_baud_set_in = -1;
int hf_sis_bus_load = -1;
int hf_3964r_character = -1;
int hf_3964r_meaning = -1;
int hf_3964r_length = -1;
int hf_3964r_doubled = -1;
int hf_3964r_end = -1;
int hf_3964r_bcc = -1;
int hf_3964r_bcc_status = -1;
int hf_3964r_data = -1;
int hf_3964r_raw = -1;
int hf_3964r_answers = -1;
int hf_3964r_answer_in = -1;
int hf_3964r_answer_time = -1;
int hf_3964r_try = -1;
int hf_3964r_repeat_of = -1;
int hf_3964r_unanswered_before = -1;
int hf_3964r_qvz_limit = -1;
int hf_3964r_qvz_verdict = -1;
int hf_3964r_zvz_interval_max = -1;
int hf_3964r_zvz_position = -1;
int hf_3964r_zvz_limit = -1;
int hf_3964r_zvz_verdict = -1;
int hf_rk512i_follow_up = -1;
int hf_rk512i_zero = -1;
int hf_rk512i_command = -1;
int hf_rk512i_kind = -1;
int hf_rk512i_block = -1;
int hf_rk512i_block_word = -1;
int hf_rk512i_word = -1;
int hf_rk512i_count = -1;
int hf_rk512i_flag_byte = -1;
int hf_rk512i_flag = -1;
int hf_rk512i_error = -1;
int hf_rk512i_data = -1;
int hf_arcnet7f_id = -1;
int hf_arcnet7f_message = -1;
int hf_arcnet7f_command = -1;
int hf_arcnet7f_type = -1;
int hf_arcnet7f_length = -1;
int hf_arcnet7f_block = -1;
int hf_arcnet7f_word = -1;
int hf_arcnet7f_list_actual = -1;
int hf_arcnet7f_list_maximum = -1;
int hf_arcnet7f_first_in = -1;
int hf_synax_request_in = -1;
int hf_synax_answer_in = -1;
int hf_synax_answer_time = -1;
int hf_synax_next_request_in = -1;
int hf_synax_unanswered_in = -1;
int hf_synax_info = -1;
int hf_synax_info_open = -1;
int hf_synax_info_last = -1;
int hf_synax_info_write = -1;
int hf_synax_axis = -1;
int hf_synax_pieces = -1;
int hf_synax_pieces_piece = -1;
int hf_synax_pieces_overlap = -1;
int hf_synax_pieces_overlap_conflict = -1;
int hf_synax_pieces_multiple_tails = -1;
int hf_synax_pieces_too_long = -1;
int hf_synax_pieces_error = -1;
int hf_synax_pieces_count = -1;
int hf_synax_pieces_whole_in = -1;
int hf_synax_pieces_length = -1;
int hf_synaxpk_word = -1;
int hf_synaxpk_word_open = -1;
int hf_synaxpk_word_error = -1;
int hf_synaxpk_word_read = -1;
int hf_synaxpk_word_busy = -1;
int hf_synaxpk_word_last = -1;
int hf_synaxpk_word_bit9 = -1;
int hf_synaxpk_word_toggle = -1;
int hf_synaxpk_word_count = -1;
int hf_synaxpk_word_format = -1;
int hf_synaxpk_sender = -1;
int hf_synaxpk_payload = -1;
int hf_synaxpk_beyond = -1;
int hf_synaxpk_byte = -1;
int hf_synaxpk_class = -1;
int hf_synaxpk_class_code = -1;
int hf_synaxpk_code = -1;
int hf_synaxpk_sis_length = -1;
int hf_synaxpk_sis_length_repeated = -1;
int hf_synaxpk_sis_control = -1;
int hf_synaxpk_sis_service = -1;
int hf_synaxpk_drive = -1;
int hf_synaxpk_drive_pf = -1;
int hf_synaxpk_drive_error = -1;
int hf_synaxpk_drive_last = -1;
int hf_synaxpk_drive_toggle = -1;
int hf_synaxpk_drive_fragment = -1;
int hf_synaxpk_drive_length = -1;
int hf_synaxpk_index = -1;
int hf_synaxpk_subindex = -1;
int hf_synaxobj_index = -1;
int hf_synaxobj_operation = -1;
int hf_synaxobj_raw = -1;
int hf_synaxobj_padding = -1;
int hf_synaxobj_open_bit = -1;
int hf_synaxobj_diagnosis = -1;
int hf_synaxobj_diagnosis_interface = -1;
int hf_synaxobj_diagnosis_fault = -1;
int hf_synaxobj_status = -1;
int hf_synaxobj_status_bus = -1;
int hf_synaxobj_status_memory = -1;
int hf_synaxobj_ppc = -1;
int hf_synaxobj_fault = -1;
int hf_synaxobj_fault_communication = -1;
int hf_synaxobj_fault_process_data = -1;
int hf_synaxpcp_service = -1;
int hf_synaxpcp_count = -1;
int hf_synaxpcp_invoke = -1;
int hf_synaxpcp_reference = -1;
int hf_synaxpcp_index = -1;
int hf_synaxpcp_index_of_request = -1;
int hf_synaxpcp_subindex = -1;
int hf_synaxpcp_length = -1;
int hf_synaxpcp_data = -1;
int hf_synaxpcp_padding = -1;
int hf_synaxpcp_result = -1;
int hf_synaxpcp_error = -1;
int hf_synaxpcp_error_class = -1;
int hf_synaxpcp_error_code = -1;
int hf_synaxpcp_error_additional = -1;
int hf_synaxpcp_raw = -1;
int hf_synaxpcp_request_in = -1;
int hf_synaxpcp_response_in = -1;
int hf_synaxpcp_response_time = -1;
int hf_synaxpd_direction = -1;
int hf_synaxpd_word = -1;
int hf_synaxpd_value = -1;
int hf_synaxpd_raw = -1;
int hf_sisascii_kind = -1;
int hf_sisascii_drive = -1;
int hf_sisascii_element = -1;
int hf_sisascii_index = -1;
int hf_sisascii_text = -1;

expert_field ei_sertap_version_unknown = EI_INIT;
expert_field ei_sertap_header_length_short = EI_INIT;
expert_field ei_sertap_count_wrong = EI_INIT;
expert_field ei_sertap_truncated = EI_INIT;
expert_field ei_sertap_error_character_expert = EI_INIT;
expert_field ei_sertap_error_break_expert = EI_INIT;
expert_field ei_sertap_error_lost_expert = EI_INIT;
expert_field ei_sertap_error_unlocated_expert = EI_INIT;
expert_field ei_sertap_before = EI_INIT;
expert_field ei_sertap_event_expert = EI_INIT;
expert_field ei_sis_list_recursion = EI_INIT;
expert_field ei_sis_command_unanswered = EI_INIT;
expert_field ei_sis_reaction_unasked = EI_INIT;
expert_field ei_sis_reaction_to_damaged = EI_INIT;
expert_field ei_sis_reaction_again = EI_INIT;
expert_field ei_sis_command_repeat = EI_INIT;
expert_field ei_sis_body_missing = EI_INIT;
expert_field ei_sis_body_unexpected = EI_INIT;
expert_field ei_sis_body_note = EI_INIT;
expert_field ei_sis_status_execution_error = EI_INIT;
expert_field ei_sis_status_telegram_error = EI_INIT;
expert_field ei_sis_start_missing = EI_INIT;
expert_field ei_sis_checksum_bad = EI_INIT;
expert_field ei_sis_length_differ = EI_INIT;
expert_field ei_sis_length_short = EI_INIT;
expert_field ei_sis_length_long = EI_INIT;
expert_field ei_sis_telegrams_many = EI_INIT;
expert_field ei_sis_length_header = EI_INIT;
expert_field ei_sis_control_reserved_set = EI_INIT;
expert_field ei_sis_control_status_set = EI_INIT;
expert_field ei_sis_control_status_error = EI_INIT;
expert_field ei_sis_control_warning_set = EI_INIT;
expert_field ei_sis_control_error_set = EI_INIT;
expert_field ei_sis_service_reserved = EI_INIT;
expert_field ei_sis_sender_service_master = EI_INIT;
expert_field ei_sis_sender_invalid = EI_INIT;
expert_field ei_sis_receiver_reserved = EI_INIT;
expert_field ei_sis_receiver_level_broadcast = EI_INIT;
expert_field ei_sis_reaction_unexpected = EI_INIT;
expert_field ei_sis_sequence_ended = EI_INIT;
expert_field ei_sis_sequence_piece_missing = EI_INIT;
expert_field ei_sis_tza_exceeded = EI_INIT;
expert_field ei_sis_tza_unresolved = EI_INIT;
expert_field ei_sis_trs_exceeded = EI_INIT;
expert_field ei_sis_trs_unresolved = EI_INIT;
expert_field ei_sis_twm_early = EI_INIT;
expert_field ei_sis_tmas_exceeded = EI_INIT;
expert_field ei_sis_tmas_unresolved = EI_INIT;
expert_field ei_sis_bus_baud_differs = EI_INIT;
expert_field ei_3964r_bcc_bad = EI_INIT;
expert_field ei_3964r_broken = EI_INIT;
expert_field ei_3964r_conflict = EI_INIT;
expert_field ei_3964r_unexpected = EI_INIT;
expert_field ei_3964r_refused = EI_INIT;
expert_field ei_3964r_repeat = EI_INIT;
expert_field ei_3964r_unanswered = EI_INIT;
expert_field ei_3964r_tries = EI_INIT;
expert_field ei_3964r_exceeded = EI_INIT;
expert_field ei_3964r_unresolved = EI_INIT;
expert_field ei_synax_note = EI_INIT;
expert_field ei_synax_short = EI_INIT;
expert_field ei_synax_unexpected = EI_INIT;
expert_field ei_synax_error = EI_INIT;
expert_field ei_synax_failed = EI_INIT;
expert_field ei_synax_unanswered = EI_INIT;
expert_field ei_synax_unanswered_before = EI_INIT;
expert_field ei_synax_pieces_too_many = EI_INIT;

void
protocol_register_sertap(void)
{
    static hf_register_info fields[] = {
        {&hf_sertap_version, {"Version", "sertap.version", FT_UINT8, BASE_DEC, NULL, 0, "Version of the record's layout", HFILL}},
        {&hf_sertap_header_length, {"Header length", "sertap.header_length", FT_UINT8, BASE_DEC, NULL, 0, "Bytes of the record before the characters", HFILL}},
        {&hf_sertap_type, {"Type", "sertap.type", FT_UINT8, BASE_DEC, VALS(sis_sertap_types), 0, "A frame, characters that belong to no frame, an event of the tap, or a frame from before this file", HFILL}},
        {&hf_sertap_line, {"Line", "sertap.line", FT_UINT8, BASE_DEC, VALS(sis_sertap_lines), 0, "The shared bus, or one direction of a full-duplex line", HFILL}},
        {&hf_sertap_baud, {"Baud rate", "sertap.baud", FT_UINT32, BASE_DEC, NULL, 0, "The rate at which the tap listened, in bits per second; 0: not known", HFILL}},
        {&hf_sertap_format, {"Character format", "sertap.format", FT_STRING, BASE_NONE, NULL, 0, "Data bits, parity and stop bits that the tap listened with", HFILL}},
        {&hf_sertap_format_data_bits, {"Data bits", "sertap.format.data_bits", FT_UINT8, BASE_DEC, NULL, 0, "Data bits of a character", HFILL}},
        {&hf_sertap_format_parity, {"Parity", "sertap.format.parity", FT_UINT8, BASE_DEC, VALS(sis_sertap_parities), 0, "Parity bit of a character", HFILL}},
        {&hf_sertap_format_stop, {"Stop bits", "sertap.format.stop", FT_UINT8, BASE_DEC, VALS(sis_sertap_stop_bits), 0, "In half bits", HFILL}},
        {&hf_sertap_framing, {"Framing", "sertap.framing", FT_UINT8, BASE_DEC, VALS(sis_sertap_framings), 0, "By which rule frames are cut", HFILL}},
        {&hf_sertap_uncertainty, {"Uncertainty of the times", "sertap.uncertainty", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "How much earlier than recorded a character can have arrived", HFILL}},
        {&hf_sertap_count, {"Count", "sertap.count", FT_UINT16, BASE_DEC, NULL, 0, "Characters, or bytes of an event's text", HFILL}},
        {&hf_sertap_event, {"Event", "sertap.event", FT_UINT16, BASE_DEC, VALS(sis_sertap_events), 0, "What happened to the tap, not on the line", HFILL}},
        {&hf_sertap_text, {"Text", "sertap.text", FT_STRING, BASE_NONE, NULL, 0, "The event in words, such as the adapter and its tuning", HFILL}},
        {&hf_sertap_data, {"Characters", "sertap.data", FT_BYTES, BASE_NONE, NULL, 0, "All characters of the record, as they were received", HFILL}},
        {&hf_sertap_character, {"Character", "sertap.character", FT_UINT8, BASE_HEX, NULL, 0, "One character with its time and its flags", HFILL}},
        {&hf_sertap_interval, {"Interval", "sertap.interval", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Since the character before it on this line, arrival to arrival", HFILL}},
        {&hf_sertap_interval_max, {"Longest interval", "sertap.interval.max", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Between two characters of this record", HFILL}},
        {&hf_sertap_flags, {"Flags", "sertap.flags", FT_UINT8, BASE_HEX, NULL, 0, "How the character arrived, and line errors", HFILL}},
        {&hf_sertap_same_read, {"Came in the same read as the one before", "sertap.same_read", FT_BOOLEAN, 8, NULL, 0x01, "Both came in one read, so the time between them is not exact", HFILL}},
        {&hf_sertap_error_character, {"Parity or framing error", "sertap.error.character", FT_BOOLEAN, 8, NULL, 0x02, "The adapter reports a parity or framing error at this character", HFILL}},
        {&hf_sertap_error_break, {"Break", "sertap.error.break", FT_BOOLEAN, 8, NULL, 0x04, "The line was held low for longer than a character", HFILL}},
        {&hf_sertap_error_lost, {"Characters lost before it", "sertap.error.lost", FT_BOOLEAN, 8, NULL, 0x08, "The computer or the adapter lost characters before this one", HFILL}},
        {&hf_sertap_error_unlocated, {"Error somewhere in its read", "sertap.error.unlocated", FT_BOOLEAN, 8, NULL, 0x10, "A line error among the characters that came in this read; the adapter does not say at which one", HFILL}},
        {&hf_sertap_interval_unknown, {"Interval unknown (first on the line)", "sertap.interval.unknown", FT_BOOLEAN, 8, NULL, 0x20, "This is the first character on the line, so there is none before it", HFILL}},
        {&hf_sertap_interval_saturated, {"Interval longer than it can be stored", "sertap.interval.saturated", FT_BOOLEAN, 8, NULL, 0x40, "More than 4.29 s passed; the time between the packets is exact", HFILL}},
    };
    static ei_register_info experts[] = {
        {&ei_sertap_version_unknown, {"sertap.version.unknown", PI_MALFORMED, PI_ERROR, "Unknown version of the record", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "A newer sistap wrote this capture. Update the plugin.", HFILL}}}},
        {&ei_sertap_header_length_short, {"sertap.header_length.short", PI_MALFORMED, PI_ERROR, "The header is shorter than version 1 has it", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The record is damaged. Write the capture again with sistap.", HFILL}}}},
        {&ei_sertap_count_wrong, {"sertap.count.wrong", PI_MALFORMED, PI_ERROR, "The count does not fit", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The record does not have as many characters as it says. Write the capture again with sistap.", HFILL}}}},
        {&ei_sertap_truncated, {"sertap.truncated", PI_MALFORMED, PI_ERROR, "The record is cut", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The capture was cut, so characters are missing. Capture without a limit of the packet length.", HFILL}}}},
        {&ei_sertap_error_character_expert, {"sertap.error.character.expert", PI_CHECKSUM, PI_WARN, "Parity or framing error on the line", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "A bit of the character was wrong when it arrived. Check baud rate and format first, then cable, termination and ground.", HFILL}}}},
        {&ei_sertap_error_break_expert, {"sertap.error.break.expert", PI_PROTOCOL, PI_WARN, "Break on the line", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The line was low for longer than a character: a short circuit, a wrong rate, or a signal on purpose. Check baud rate first, then the wires.", HFILL}}}},
        {&ei_sertap_error_lost_expert, {"sertap.error.lost.expert", PI_SEQUENCE, PI_WARN, "Characters were lost before the tap could read them", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The tap was too slow, so characters are missing here. Close other programs, or use an adapter with a larger buffer: sistap doctor.", HFILL}}}},
        {&ei_sertap_error_unlocated_expert, {"sertap.error.unlocated.expert", PI_CHECKSUM, PI_WARN, "A line error, the adapter does not say at which character", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "One of the characters of this read was wrong. Check baud rate and format first, then cable, termination and ground.", HFILL}}}},
        {&ei_sertap_before, {"sertap.before", PI_SEQUENCE, PI_CHAT, "From before this file: learned from, not counted, not judged", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The file continues another. This telegram came earlier and explains what follows: a name, a unit, a limit. Nothing. Its time is that of the beginning of the file.", HFILL}}}},
        {&ei_sertap_event_expert, {"sertap.event.expert", PI_SEQUENCE, PI_WARN, "The capture has a gap", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The tap heard nothing for a while, whatever happened on the line. Read the text of the event. Do not count silences across it.", HFILL}}}},
    };
    static int *subtrees[] = {&ett_sertap, &ett_sertap_format, &ett_sertap_characters, &ett_sertap_character};

    proto_sertap = proto_register_protocol("Serial tap", "SERTAP", "sertap");
    proto_register_field_array(proto_sertap, fields, array_length(fields));
    expert_register_field_array(expert_register_protocol(proto_sertap), experts, array_length(experts));
    proto_register_subtree_array(subtrees, array_length(subtrees));
}

void
protocol_register_sis(void)
{
    static hf_register_info fields[] = {
        {&hf_sis_data, {"Data", "sis.data", FT_BYTES, BASE_NONE, NULL, 0, "The operating data, and nothing else", HFILL}},
        {&hf_sis_raw, {"Not decoded", "sis.raw", FT_BYTES, BASE_NONE, NULL, 0, "Bytes that no document explains", HFILL}},
        {&hf_sis_value_number, {"Number", "sis.value.number", FT_DOUBLE, BASE_NONE, NULL, 0, "The value without its unit, for filters, columns and graphs", HFILL}},
        {&hf_sis_value_bit, {"Bit set", "sis.value.bit", FT_STRING, BASE_NONE, NULL, 0, "The name of a bit that is set, from the user's table", HFILL}},
        {&hf_sis_parameter, {"Parameter", "sis.parameter", FT_STRING, BASE_NONE, NULL, 0, "Kind, set and number; in a reaction taken from its command", HFILL}},
        {&hf_sis_parameter_name, {"Name", "sis.parameter.name", FT_STRING, BASE_NONE, NULL, 0, "Read on the bus, from the user's table, or built in; the text says which", HFILL}},
        {&hf_sis_parameter_unit, {"Unit", "sis.parameter.unit", FT_STRING, BASE_NONE, NULL, 0, "Read on the bus or from the user's table", HFILL}},
        {&hf_sis_parameter_minimum, {"Minimum", "sis.parameter.minimum", FT_STRING, BASE_NONE, NULL, 0, "The smallest value allowed, as it was read on the bus", HFILL}},
        {&hf_sis_parameter_maximum, {"Maximum", "sis.parameter.maximum", FT_STRING, BASE_NONE, NULL, 0, "The largest value allowed, as it was read on the bus", HFILL}},
        {&hf_sis_parameter_type, {"Type", "sis.parameter.type", FT_UINT8, BASE_DEC, VALS(sis_parameter_types), 0, "A parameter of a drive or one of the control", HFILL}},
        {&hf_sis_parameter_product_specific, {"Kind", "sis.parameter.product_specific", FT_BOOLEAN, 16, TFS(&texts_sis_parameter_product_specific), 0x8000, "S: standard of SERCOS. P: of this product only", HFILL}},
        {&hf_sis_parameter_set, {"Parameter set", "sis.parameter.set", FT_UINT16, BASE_DEC, NULL, 0x7000, "One of eight sets that a parameter can have", HFILL}},
        {&hf_sis_parameter_number, {"Number", "sis.parameter.number", FT_UINT16, BASE_DEC, NULL, 0x0FFF, "The number in the set, 0 to 4095", HFILL}},
        {&hf_sis_value, {"Value", "sis.value", FT_STRING, BASE_NONE, NULL, 0, "Scaled, with its unit where that is known", HFILL}},
        {&hf_sis_element_name, {"Name", "sis.element.name", FT_STRING, BASE_NONE, NULL, 0, "The name of the parameter, as the device tells it", HFILL}},
        {&hf_sis_element_unit, {"Unit", "sis.element.unit", FT_STRING, BASE_NONE, NULL, 0, "The unit of the parameter, as the device tells it", HFILL}},
        {&hf_sis_attribute, {"Attribute", "sis.attribute", FT_UINT32, BASE_HEX, NULL, 0, "How to read the value: length, format, decimal places, write protection", HFILL}},
        {&hf_sis_attribute_factor, {"Conversion factor", "sis.attribute.factor", FT_UINT32, BASE_DEC, NULL, 0x0000FFFF, "Multiply the value by it", HFILL}},
        {&hf_sis_attribute_length, {"Length", "sis.attribute.length", FT_UINT32, BASE_DEC, VALS(sis_attribute_lengths), 0x00070000, "Bytes of the value, or of each element of a list", HFILL}},
        {&hf_sis_attribute_command, {"Procedure command", "sis.attribute.command", FT_BOOLEAN, 32, NULL, 0x00080000, "Writing the parameter starts a procedure command", HFILL}},
        {&hf_sis_attribute_format, {"Format", "sis.attribute.format", FT_UINT32, BASE_DEC, VALS(sis_attribute_formats), 0x00700000, "How to show the value", HFILL}},
        {&hf_sis_attribute_decimals, {"Decimal places", "sis.attribute.decimals", FT_UINT32, BASE_DEC, NULL, 0x0F000000, "Digits after the decimal point", HFILL}},
        {&hf_sis_attribute_protected_2, {"Write-protected in phase 2", "sis.attribute.protected_2", FT_BOOLEAN, 32, NULL, 0x10000000, "Cannot be written in phase 2", HFILL}},
        {&hf_sis_attribute_protected_3, {"Write-protected in phase 3", "sis.attribute.protected_3", FT_BOOLEAN, 32, NULL, 0x20000000, "Cannot be written in phase 3", HFILL}},
        {&hf_sis_attribute_protected_4, {"Write-protected in phase 4", "sis.attribute.protected_4", FT_BOOLEAN, 32, NULL, 0x40000000, "Cannot be written in phase 4", HFILL}},
        {&hf_sis_list_actual, {"Actual length of the list", "sis.list.actual", FT_UINT16, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_sis_list_actual), 0, "Bytes that the list has now; the first word of a list", HFILL}},
        {&hf_sis_list_maximum, {"Maximum length of the list", "sis.list.maximum", FT_UINT16, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_sis_list_maximum), 0, "Bytes that the list can have; the second word of a list", HFILL}},
        {&hf_sis_access, {"Access", "sis.access", FT_STRING, BASE_NONE, NULL, 0, "What was read or written of a parameter, as JSON: for programs", HFILL}},
        {&hf_sis_packed, {"Fields of this telegram", "sis.packed", FT_STRING, BASE_NONE, NULL, 0, "The fields of a telegram that is not the first of its packet, with the number of values of each: for programs", HFILL}},
        {&hf_sis_text, {"Text", "sis.text", FT_STRING, BASE_NONE, NULL, 0, "Useful data of a product group that are plain ASCII", HFILL}},
        {&hf_sis_element_length, {"Length", "sis.element_length", FT_UINT8, BASE_DEC, NULL, 0, "Service and body of this element", HFILL}},
        {&hf_sis_stream, {"Stream", "sis.stream", FT_UINT32, BASE_DEC, NULL, 0, "One number for each pair of stations", HFILL}},
        {&hf_sis_reaction_in, {"Reaction in", "sis.reaction_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RESPONSE), 0, "The packet that answers this command", HFILL}},
        {&hf_sis_command_in, {"Command in", "sis.command_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_REQUEST), 0, "The packet that this reaction answers", HFILL}},
        {&hf_sis_reaction_time, {"Reaction time", "sis.reaction_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "From the last character of the command to the first of the reaction; from packet to packet where the times of the characters are not known; not there if both came in one read of the tap, or the clock was set back between them. With an operator terminal BTV05, command and reaction together take 100 ms at most (chapter 10.1)", HFILL}},
        {&hf_sis_reaction_time_ms, {"Reaction time in ms", "sis.reaction_time.ms", FT_DOUBLE, BASE_CUSTOM, CF_FUNC(format_ms), 0, "For a column of the packet list", HFILL}},
        {&hf_sis_repeat_of, {"Repeat of", "sis.repeat_of", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RETRANS_PREV), 0, "The packet that this command repeats, byte for byte", HFILL}},
        {&hf_sis_unanswered_before, {"Command before, not answered", "sis.unanswered_before", FT_FRAMENUM, BASE_NONE, NULL, 0, "The master's command before this one, where it went on without a reaction", HFILL}},
        {&hf_sis_next_command_in, {"Next command in", "sis.next_command_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The master's next command, where it went on without a reaction", HFILL}},
        {&hf_sis_answered_in, {"Answered before in", "sis.answered_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "An earlier reaction to the same command", HFILL}},
        {&hf_sis_routed_from, {"Routed from", "sis.routed_from", FT_FRAMENUM, BASE_NONE, NULL, 0, "The same telegram on the level it came from", HFILL}},
        {&hf_sis_service, {"Service", "sis.service", FT_UINT8, BASE_HEX | BASE_RANGE_STRING, RVALS(sis_services), 0, "What the telegram asks for; a reaction repeats it", HFILL}},
        {&hf_sis_status, {"Status", "sis.status", FT_UINT8, BASE_HEX | BASE_RANGE_STRING, RVALS(sis_status), 0, "Whether the command was executed: the first byte of a reaction's useful data", HFILL}},
        {&hf_sis_device, {"Device address", "sis.device", FT_UINT8, BASE_DEC, NULL, 0, "Of the device behind the station; its own address, or 0 for the control itself", HFILL}},
        {&hf_sis_subservice, {"Subservice", "sis.subservice", FT_UINT8, BASE_HEX, NULL, 0, "What exactly the service shall do", HFILL}},
        {&hf_sis_error, {"Error code", "sis.error", FT_UINT16, BASE_HEX, NULL, 0, "The full code, where a byte is sent together with its subservice; some codes are followed by advice", HFILL}},
        {&hf_sis_phase, {"Phase", "sis.phase", FT_UINT8, BASE_DEC, NULL, 0, "Communication phase of SERCOS: 2 parameter mode, 4 operating mode", HFILL}},
        {&hf_sis_init_baud_mask, {"Baud rate mask", "sis.init.baud_mask", FT_UINT8, BASE_HEX, NULL, 0, "One bit for each baud rate; 0: 9600", HFILL}},
        {&hf_sis_start, {"Start character", "sis.start", FT_UINT8, BASE_HEX, NULL, 0, "Every telegram begins with 0x02", HFILL}},
        {&hf_sis_checksum, {"Checksum", "sis.checksum", FT_UINT8, BASE_HEX, NULL, 0, "Makes the sum of all bytes 0 modulo 256", HFILL}},
        {&hf_sis_checksum_status, {"Checksum Status", "sis.checksum.status", FT_UINT8, BASE_NONE, VALS(sis_checksum_states), 0, "Whether the sum of all bytes is 0; unverified if bytes are missing", HFILL}},
        {&hf_sis_length, {"Data length", "sis.length", FT_UINT8, BASE_DEC, NULL, 0, "Bytes after the static header of 8", HFILL}},
        {&hf_sis_length_repeat, {"Data length repetition", "sis.length_repeat", FT_UINT8, BASE_DEC, NULL, 0, "Must equal the data length", HFILL}},
        {&hf_sis_control, {"Telegram control", "sis.control", FT_UINT8, BASE_HEX, NULL, 0, "Subaddresses, telegram number, direction; bits 5 to 7 differ between the editions", HFILL}},
        {&hf_sis_control_subaddresses, {"Subaddresses", "sis.control.subaddresses", FT_UINT8, BASE_DEC, NULL, 0x07, "How many subaddresses follow the receiver address", HFILL}},
        {&hf_sis_control_number, {"Telegram number", "sis.control.number", FT_BOOLEAN, 8, TFS(&texts_sis_control_number), 0x08, "Whether a telegram number follows the addresses", HFILL}},
        {&hf_sis_control_reaction, {"Kind", "sis.control.reaction", FT_BOOLEAN, 8, TFS(&texts_sis_control_reaction), 0x10, "Command of a master, or reaction of a station", HFILL}},
        {&hf_sis_control_reserved, {"Reserved", "sis.control.reserved", FT_BOOLEAN, 8, NULL, 0x20, "Not used in the edition IF02", HFILL}},
        {&hf_sis_control_warning, {"System warning of the sender", "sis.control.warning", FT_BOOLEAN, 8, NULL, 0x40, "The sender has a system warning (IF02)", HFILL}},
        {&hf_sis_control_error, {"System error of the sender", "sis.control.error", FT_BOOLEAN, 8, NULL, 0x80, "The sender has a system error (IF02)", HFILL}},
        {&hf_sis_control_reserved_bits, {"Reserved", "sis.control.reserved_bits", FT_UINT8, BASE_HEX, NULL, 0xE0, "Not used in a command (ECODRIVE03)", HFILL}},
        {&hf_sis_control_status, {"Status", "sis.control.status", FT_UINT8, BASE_DEC, VALS(sis_control_status_ecodrive03), 0xE0, "How far the command is (ECODRIVE03)", HFILL}},
        {&hf_sis_sender, {"Sender address", "sis.sender", FT_UINT8, BASE_DEC, NULL, 0, "The byte in the header; a reaction keeps the master's", HFILL}},
        {&hf_sis_receiver, {"Receiver address", "sis.receiver", FT_UINT8, BASE_DEC, NULL, 0, "The byte in the header; a reaction keeps the slave's", HFILL}},
        {&hf_sis_subaddress, {"Subaddress", "sis.subaddress", FT_UINT8, BASE_DEC, NULL, 0, "The next station of a route through routers", HFILL}},
        {&hf_sis_number, {"Telegram number", "sis.number", FT_UINT8, BASE_DEC, NULL, 0, "Tells a repeated command from a new one; 0: no check", HFILL}},
        {&hf_sis_talker, {"Talker", "sis.talker", FT_UINT8, BASE_DEC, NULL, 0, "Who really sends: a reaction keeps the command's addresses", HFILL}},
        {&hf_sis_listener, {"Listener", "sis.listener", FT_UINT8, BASE_DEC, NULL, 0, "For whom it really is", HFILL}},
        {&hf_sis_station, {"Station", "sis.station", FT_UINT8, BASE_DEC, NULL, 0, "Talker or listener", HFILL}},
        {&hf_sis_sequence, {"Pieces", "sis.sequence", FT_NONE, BASE_NONE, NULL, 0, "The telegrams that carry the pieces of these data", HFILL}},
        {&hf_sis_sequence_piece, {"Piece", "sis.sequence.piece", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet with this piece", HFILL}},
        {&hf_sis_sequence_overlap, {"Overlap", "sis.sequence.overlap", FT_BOOLEAN, BASE_NONE, NULL, 0, "This piece repeats bytes of another", HFILL}},
        {&hf_sis_sequence_overlap_conflict, {"Overlap with other data", "sis.sequence.overlap.conflict", FT_BOOLEAN, BASE_NONE, NULL, 0, "This piece repeats bytes of another with other contents", HFILL}},
        {&hf_sis_sequence_multiple_tails, {"Several last pieces", "sis.sequence.multiple_tails", FT_BOOLEAN, BASE_NONE, NULL, 0, "More than one piece says that it is the last", HFILL}},
        {&hf_sis_sequence_too_long, {"Piece too long", "sis.sequence.too_long", FT_BOOLEAN, BASE_NONE, NULL, 0, "This piece goes beyond the end of the data", HFILL}},
        {&hf_sis_sequence_error, {"Error while putting together", "sis.sequence.error", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet in which the pieces did not fit", HFILL}},
        {&hf_sis_sequence_count, {"Number of pieces", "sis.sequence.count", FT_UINT32, BASE_DEC, NULL, 0, "How many telegrams carry these data", HFILL}},
        {&hf_sis_sequence_whole_in, {"The whole is in", "sis.sequence.whole_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet that shows the joined data", HFILL}},
        {&hf_sis_sequence_length, {"Length of the whole", "sis.sequence.length", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_sis_sequence_length), 0, "Bytes of the joined data", HFILL}},
        {&hf_sis_sequence_begun_in, {"Unfinished transfer begun in", "sis.sequence.begun_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet with the first piece of the transfer that ended unfinished", HFILL}},
        {&hf_sis_canceled_service, {"Cancelled service", "sis.canceled_service", FT_UINT8, BASE_HEX | BASE_RANGE_STRING, RVALS(sis_services), 0, "The transfer of this service shall end", HFILL}},
        {&hf_sis_flash_address, {"Memory address", "sis.flash.address", FT_UINT32, BASE_HEX, NULL, 0, "Where in the memory of the drive the operation begins", HFILL}},
        {&hf_sis_flash_length, {"Length", "sis.flash.length", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_sis_flash_length), 0, "How many bytes of memory the operation covers", HFILL}},
        {&hf_sis_flash_target, {"Target", "sis.flash.target", FT_UINT8, BASE_HEX, VALS(sis_shutdown_targets), 0, "The program that runs after the shutdown", HFILL}},
        {&hf_sis_flash_device_type, {"Device type", "sis.flash.device_type", FT_UINT8, BASE_HEX, VALS(sis_device_types), 0, "The kind of memory that is programmed", HFILL}},
        {&hf_sis_flash_crc32, {"CRC32", "sis.flash.crc32", FT_UINT32, BASE_HEX, NULL, 0, "Checksum of the module, as IndraDrive returns it", HFILL}},
        {&hf_sis_version, {"SIS version", "sis.version", FT_STRING, BASE_NONE, NULL, 0, "Version of SIS that the station speaks, such as 01V01", HFILL}},
        {&hf_sis_firmware, {"Firmware (FWA) number", "sis.firmware", FT_STRING, BASE_NONE, NULL, 0, "Which firmware the station runs", HFILL}},
        {&hf_sis_type_key, {"Device type key", "sis.type_key", FT_STRING, BASE_NONE, NULL, 0, "Which device the station is", HFILL}},
        {&hf_sis_init_time, {"Time", "sis.init.time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "The limit that this telegram sets: TrS, TzA or Tmas", HFILL}},
        {&hf_sis_init_test_time, {"Duration of the test", "sis.init.test_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "How long the station stays at the tested baud rate", HFILL}},
        {&hf_sis_parameter_control, {"Parameter control", "sis.parameter_control", FT_UINT8, BASE_HEX, NULL, 0, "Which element of the parameter, and whether more telegrams follow", HFILL}},
        {&hf_sis_parameter_control_reserved, {"Reserved", "sis.parameter_control.reserved", FT_UINT8, BASE_HEX, NULL, 0xC3, "Bits that must be 0", HFILL}},
        {&hf_sis_element, {"Element", "sis.element", FT_UINT8, BASE_DEC, VALS(sis_elements), 0x38, "What is accessed: the value (operating data), its name, unit, attribute or limits", HFILL}},
        {&hf_sis_transmission, {"Transmission", "sis.transmission", FT_BOOLEAN, 8, TFS(&texts_sis_transmission), 0x04, "Whether this is the last telegram of the transfer", HFILL}},
        {&hf_sis_list_offset, {"List offset", "sis.list_offset", FT_UINT16, BASE_DEC, NULL, 0, "Where the segment begins; in words for 0x81 and 0x8E, else in bytes", HFILL}},
        {&hf_sis_list_length, {"List length", "sis.list_length", FT_UINT16, BASE_DEC, NULL, 0, "How long the segment is; in words for 0x81 and 0x8E, else in bytes", HFILL}},
        {&hf_sis_data_status, {"Data status", "sis.data_status", FT_UINT16, BASE_HEX, NULL, 0, "How far a procedure command is", HFILL}},
        {&hf_sis_data_status_set, {"Command set", "sis.data_status.set", FT_BOOLEAN, 16, NULL, 0x0001, "Somebody has set the command", HFILL}},
        {&hf_sis_data_status_enabled, {"Command enabled", "sis.data_status.enabled", FT_BOOLEAN, 16, NULL, 0x0002, "The command runs; if not set, it is interrupted", HFILL}},
        {&hf_sis_data_status_not_executed, {"Not yet executed", "sis.data_status.not_executed", FT_BOOLEAN, 16, NULL, 0x0004, "The command has not ended yet", HFILL}},
        {&hf_sis_data_status_impossible, {"Execution not possible", "sis.data_status.impossible", FT_BOOLEAN, 16, NULL, 0x0008, "The command ended with an error", HFILL}},
        {&hf_sis_data_status_invalid, {"Operating data invalid", "sis.data_status.invalid", FT_BOOLEAN, 16, NULL, 0x0100, "The value cannot be trusted now", HFILL}},
        {&hf_sis_phase_switch_in, {"Phase switch in", "sis.phase.switch_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet that asked for the phase switch which this poll observes", HFILL}},
        {&hf_sis_phase_switch_time, {"Time of the phase switch", "sis.phase.switch_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "From its command to the poll that ended it", HFILL}},
        {&hf_sis_silence_before, {"Silence before", "sis.silence_before", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Since the character before it on this line, arrival to arrival. An operator terminal BTV05 takes its link for lost after 200 ms of silence", HFILL}},
        {&hf_sis_silence_before_ms, {"Silence before in ms", "sis.silence_before.ms", FT_DOUBLE, BASE_CUSTOM, CF_FUNC(format_ms), 0, "For a column of the packet list", HFILL}},
        {&hf_sis_tza_interval_max, {"Longest interval", "sis.tza.interval_max", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Between two characters of the telegram, arrival to arrival; where they came in one read, the most it can have been", HFILL}},
        {&hf_sis_tza_interval_max_ms, {"Longest interval in ms", "sis.tza.interval_max.ms", FT_DOUBLE, BASE_CUSTOM, CF_FUNC(format_ms), 0, "For a column of the packet list", HFILL}},
        {&hf_sis_tza_position, {"Longest interval before character", "sis.tza.position", FT_UINT16, BASE_DEC, NULL, 0, "Its number in the telegram, from 1", HFILL}},
        {&hf_sis_tza_limit, {"TzA (longest interval allowed)", "sis.tza.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "As the bus was told, or from the preference sis.tza_ms", HFILL}},
        {&hf_sis_tza_set_in, {"TzA set in", "sis.tza.set_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet that made this limit valid", HFILL}},
        {&hf_sis_tza_verdict, {"Verdict on TzA", "sis.tza.verdict", FT_UINT8, BASE_DEC, VALS(sis_verdicts), 0, "Whether the intervals in this telegram keep TzA, with the uncertainty of their times", HFILL}},
        {&hf_sis_trs_limit, {"TrS (longest reaction time allowed)", "sis.trs.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "As the bus was told, or from the preference sis.trs_ms", HFILL}},
        {&hf_sis_trs_set_in, {"TrS set in", "sis.trs.set_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet that made this limit valid", HFILL}},
        {&hf_sis_trs_verdict, {"Verdict on TrS", "sis.trs.verdict", FT_UINT8, BASE_DEC, VALS(sis_verdicts), 0, "Whether this reaction keeps TrS, with the uncertainty of its time", HFILL}},
        {&hf_sis_twm_wait, {"Wait of the master (TwM)", "sis.twm.wait", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Since the end of its command before: of the one that is repeated, or of a broadcast", HFILL}},
        {&hf_sis_tmas_before_in, {"Master control word before in", "sis.tmas.before_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet with the master control word before this one", HFILL}},
        {&hf_sis_tmas_cycle, {"Master control word cycle", "sis.tmas.cycle", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Between two writings of S-0-0134 to the same device, begin to begin", HFILL}},
        {&hf_sis_tmas_limit, {"Tmas (longest cycle allowed)", "sis.tmas.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "While the machine moves", HFILL}},
        {&hf_sis_tmas_set_in, {"Tmas set in", "sis.tmas.set_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet that made this limit valid", HFILL}},
        {&hf_sis_tmas_verdict, {"Verdict on Tmas", "sis.tmas.verdict", FT_UINT8, BASE_DEC, VALS(sis_verdicts), 0, "Whether this master control word keeps Tmas, with the uncertainty of its time", HFILL}},
        {&hf_sis_bus_baud, {"Baud rate of the bus", "sis.bus.baud", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_sis_bus_baud), 0, "As the bus was told", HFILL}},
        {&hf_sis_bus_baud_set_in, {"Baud rate set in", "sis.bus.baud.set_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet that made this rate valid", HFILL}},
        {&hf_sis_bus_load, {"Bus load", "sis.bus.load", FT_DOUBLE, BASE_NONE, NULL, 0, "Percent of the last second in which there were characters on the line", HFILL}},
    };
    static ei_register_info experts[] = {
        {&ei_sis_list_recursion, {"sis.list.recursion", PI_PROTOCOL, PI_ERROR, "Service 0x04 must not be in its own list", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The station must refuse this list. Take service 0x04 out of the list of the master.", HFILL}}}},
        {&ei_sis_command_unanswered, {"sis.command.unanswered", PI_SEQUENCE, PI_NOTE, "No reaction before the next command", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The master went on without a reaction. Look whether this station answers at other times. If never: address, cable, power. If sometimes: compare its reaction times with the master's time-out.", HFILL}}}},
        {&ei_sis_reaction_unasked, {"sis.reaction.unasked", PI_SEQUENCE, PI_NOTE, "The command of this reaction is not known", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "No command before it fits: the capture may have begun later, or the command was damaged. Look at the packets before it. If it comes often, two stations may have the same address.", HFILL}}}},
        {&ei_sis_reaction_to_damaged, {"sis.reaction.to_damaged", PI_SEQUENCE, PI_CHAT, "The answer to a damaged command: allowed only point to point; on a bus the station is silent", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The station could not read the command and says so. It did nothing. Look for the damage in the packet before. The master should send its command again.", HFILL}}}},
        {&ei_sis_reaction_again, {"sis.reaction.again", PI_SEQUENCE, PI_NOTE, "The command was answered before", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The station, or a second one, has answered the same command again. Look for a repeat by the master, and for two stations with one address.", HFILL}}}},
        {&ei_sis_command_repeat, {"sis.command.repeat", PI_SEQUENCE, PI_NOTE, "The same command again", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The master sends a command again, because no good reaction came in time. Look at the command before it: was it damaged, not answered, or answered too late?", HFILL}}}},
        {&ei_sis_body_missing, {"sis.body.missing", PI_PROTOCOL, PI_WARN, "Useful data are missing", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The useful data end before all fields are there. Compare the master's telegram with the service's layout.", HFILL}}}},
        {&ei_sis_body_unexpected, {"sis.body.unexpected", PI_PROTOCOL, PI_WARN, "More useful data than the service has", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "Bytes follow that the service does not have. Compare the master's telegram with the service's layout. Another edition or product may have more.", HFILL}}}},
        {&ei_sis_body_note, {"sis.body.note", PI_PROTOCOL, PI_NOTE, "Useful data that the documents do not define", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The documents do not define this value, or leave its meaning open. Read the text of the item. Often the device is newer than the documents.", HFILL}}}},
        {&ei_sis_status_execution_error, {"sis.status.execution_error", PI_RESPONSE_CODE, PI_NOTE, "The status is an execution error", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The station understood the command but could not execute it. Read the error code in the reaction.", HFILL}}}},
        {&ei_sis_status_telegram_error, {"sis.status.telegram_error", PI_RESPONSE_CODE, PI_WARN, "The status is a telegram error", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The station did not accept the command. Compare the command with its service: length, checksum, service, subaddresses.", HFILL}}}},
        {&ei_sis_start_missing, {"sis.start.missing", PI_MALFORMED, PI_ERROR, "No start character 0x02", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The bytes do not begin like a telegram. Check baud rate and format of the capture, and that the data really are SIS.", HFILL}}}},
        {&ei_sis_checksum_bad, {"sis.checksum.bad", PI_CHECKSUM, PI_ERROR, "Wrong checksum", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "A byte was changed or lost on the way to the tap. Look at line errors and losses at this packet. Check cable, termination, ground and baud rate.", HFILL}}}},
        {&ei_sis_length_differ, {"sis.length.differ", PI_MALFORMED, PI_ERROR, "The two lengths differ: a bus does not answer this telegram, a point-to-point station answers with status 0xF2", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "One of the two lengths was damaged, so nobody knows where the telegram ends. Look at line errors and losses at this packet. Check cable, termination, ground and baud rate.", HFILL}}}},
        {&ei_sis_length_short, {"sis.length.short", PI_MALFORMED, PI_ERROR, "The telegram is cut", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The telegram ends before its last byte. If the capture began or ended here, nothing is wrong. Else look for lost characters.", HFILL}}}},
        {&ei_sis_length_long, {"sis.length.long", PI_PROTOCOL, PI_WARN, "Bytes follow the end of the telegram", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The packet has more bytes than the telegram. Check the program that made the capture: one telegram a packet is expected.", HFILL}}}},
        {&ei_sis_telegrams_many, {"sis.telegrams.many", PI_UNDECODED, PI_NOTE, "More telegrams in a packet than are decoded: only those that begin in its first 32,768 bytes", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The rest of the packet is not decoded. Cut the data into smaller packets.", HFILL}}}},
        {&ei_sis_length_header, {"sis.length.header", PI_MALFORMED, PI_ERROR, "Subaddresses and telegram number do not fit into the length", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The length is too small for the subaddresses and the telegram number that the header announces. Check the program of the sender.", HFILL}}}},
        {&ei_sis_control_reserved_set, {"sis.control.reserved.set", PI_PROTOCOL, PI_NOTE, "Reserved bits of the telegram control are set (another edition? preference sis.edition)", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "IF02 and ECODRIVE03 use these bits in different ways. Try the other edition: preference sis.edition.", HFILL}}}},
        {&ei_sis_control_status_set, {"sis.control.status.set", PI_RESPONSE_CODE, PI_NOTE, "The status in the telegram control is not 'no error'", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The station reports that the command is not done, or with a warning. Read the status. The master may have to ask again.", HFILL}}}},
        {&ei_sis_control_status_error, {"sis.control.status.error", PI_RESPONSE_CODE, PI_WARN, "The status in the telegram control is an error", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The station could not do what the command asks. Read the error code in the reaction.", HFILL}}}},
        {&ei_sis_control_warning_set, {"sis.control.warning.set", PI_RESPONSE_CODE, PI_NOTE, "The sender signals a system warning", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The sender has a warning, whatever this telegram is about. Read the diagnosis of that device, such as S-0-0390 or S-0-0095.", HFILL}}}},
        {&ei_sis_control_error_set, {"sis.control.error.set", PI_RESPONSE_CODE, PI_WARN, "The sender signals a system error", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The sender has an error, whatever this telegram is about. Read the diagnosis of that device, such as S-0-0390 or S-0-0095.", HFILL}}}},
        {&ei_sis_service_reserved, {"sis.service.reserved", PI_PROTOCOL, PI_NOTE, "Reserved service", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "No document describes this service. Check the sender's program, and the preference sis.edition.", HFILL}}}},
        {&ei_sis_sender_service_master, {"sis.sender.service_master", PI_PROTOCOL, PI_NOTE, "Address 127, for service and emergencies only: not to be used while other masters communicate", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "Somebody has connected a service tool or an emergency master. Make sure that no other master speaks at the same time.", HFILL}}}},
        {&ei_sis_sender_invalid, {"sis.sender.invalid", PI_PROTOCOL, PI_WARN, "A sender address is not above 127", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "No station can have this address. Check the sender's settings, and the preference sis.edition.", HFILL}}}},
        {&ei_sis_receiver_reserved, {"sis.receiver.reserved", PI_PROTOCOL, PI_WARN, "Receiver address that is not assigned or reserved (another edition? preference sis.edition)", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "No station can have this address in this edition. Check the receiver address, and the preference sis.edition.", HFILL}}}},
        {&ei_sis_receiver_level_broadcast, {"sis.receiver.level_broadcast", PI_PROTOCOL, PI_WARN, "254 may only be the last address of the list", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "After 254 no other address may follow. Correct the route in the master.", HFILL}}}},
        {&ei_sis_reaction_unexpected, {"sis.reaction.unexpected", PI_PROTOCOL, PI_WARN, "A group or broadcast is not answered", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "Several stations would answer at once. Check which station answers to a group or broadcast address.", HFILL}}}},
        {&ei_sis_sequence_ended, {"sis.sequence.ended", PI_SEQUENCE, PI_NOTE, "A transfer of sequential telegrams ended unfinished", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The pieces that came so far are not the whole value. Look what came between: a cancel, an error, or another access to the same device.", HFILL}}}},
        {&ei_sis_sequence_piece_missing, {"sis.sequence.piece_missing", PI_SEQUENCE, PI_NOTE, "A piece of this transfer may be missing: something that came between was damaged, lost or refused", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The data are not joined, because one piece may be missing. Look for damaged or lost characters between the pieces. Then read the value again.", HFILL}}}},
        {&ei_sis_tza_exceeded, {"sis.tza.exceeded", PI_PROTOCOL, PI_WARN, "TzA exceeded", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The receiver may have dropped this telegram. Look which station talks, and at which character. Reduce its load, or set a longer TzA.", HFILL}}}},
        {&ei_sis_tza_unresolved, {"sis.tza.unresolved", PI_PROTOCOL, PI_NOTE, "TzA perhaps exceeded", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The interval may be longer or shorter than TzA: its time is not exact enough, or it depends on whether the character that ends it counts. No document says that. Make the times more exact: instead of a log, capture with sistap, with the latency timer of an FTDI adapter at 1 ms. sistap doctor says how. A logic analyser decides to a microsecond. If it depends on where TzA begins to count and you know it, set the preference sis.tza_from.", HFILL}}}},
        {&ei_sis_trs_exceeded, {"sis.trs.exceeded", PI_PROTOCOL, PI_WARN, "TrS exceeded", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The master may have given up before this reaction came. Look which station is late, and in which service. Set a longer TrS in the master if the station may be that slow.", HFILL}}}},
        {&ei_sis_trs_unresolved, {"sis.trs.unresolved", PI_PROTOCOL, PI_NOTE, "TrS perhaps exceeded", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The reaction may be later than TrS or not: its time is not exact enough, or it depends on whether its first character counts. No document says that. Make the times more exact: instead of a log, capture with sistap, with the latency timer of an FTDI adapter at 1 ms. sistap doctor says how. A logic analyser decides to a microsecond.", HFILL}}}},
        {&ei_sis_twm_early, {"sis.twm.early", PI_SEQUENCE, PI_NOTE, "Repeated before TrS was over", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The master did not wait until the slave's time was over. Set the waiting time of the master (TwM) longer than TrS.", HFILL}}}},
        {&ei_sis_tmas_exceeded, {"sis.tmas.exceeded", PI_PROTOCOL, PI_WARN, "Tmas exceeded", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The drive may have stopped, because the master control word came too late. Look what kept the master from writing S-0-0134.", HFILL}}}},
        {&ei_sis_tmas_unresolved, {"sis.tmas.unresolved", PI_PROTOCOL, PI_NOTE, "Tmas perhaps exceeded", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The cycle may be longer than Tmas or not: its times are not exact enough. Make the times more exact: instead of a log, capture with sistap, with the latency timer of an FTDI adapter at 1 ms. sistap doctor says how. A logic analyser decides to a microsecond.", HFILL}}}},
        {&ei_sis_bus_baud_differs, {"sis.bus.baud.differs", PI_PROTOCOL, PI_NOTE, "The tap listens at another baud rate than the bus was told", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "Stations were told to use another rate than the one that the tap listens at. Start the tap with --follow-baud, or with the new rate.", HFILL}}}},
    };
    static int *subtrees[] = {&ett_sis, &ett_sis_control, &ett_sis_parameter_control, &ett_sis_data_status, &ett_sis_whole, &ett_sis_element, &ett_sis_sequence, &ett_sis_piece, &ett_sis_timing, &ett_sis_ident, &ett_sis_attribute, &ett_sis_list, &ett_sis_value};
    module_t *module;

    proto_sis = proto_register_protocol("Rexroth SIS serial protocol", "SIS", "sis");
    proto_register_field_array(proto_sis, fields, array_length(fields));
    expert_register_field_array(expert_register_protocol(proto_sis), experts, array_length(experts));
    proto_register_subtree_array(subtrees, array_length(subtrees));
    module = prefs_register_protocol(proto_sis, NULL);
    prefs_register_enum_preference(module, "edition", "Edition of the telegram header", "Address ranges, and bits 5 to 7 of the telegram control, differ between editions", &pref_sis_edition, choices_sis_edition, FALSE);
    prefs_register_bool_preference(module, "clc_as_sercos", "Decode services 0xC0 to 0xCF like 0x10 to 0x1F", "The CLC's services are said to be close to the SERCOS services; their layout is not documented", &pref_sis_clc_as_sercos);
    prefs_register_bool_preference(module, "ecodrive_phases", "Decode services 0x82 and 0x8D like 0x12 and 0x1D", "Reading and switching the phase of an ECODRIVE this way is not confirmed", &pref_sis_ecodrive_phases);
    prefs_register_uint_preference(module, "tza_ms", "TzA in ms", "Longest interval allowed between two characters of a telegram; 0: as the bus was told", 10, &pref_sis_tza_ms);
    prefs_register_enum_preference(module, "tza_from", "TzA counts from", "No document says whether the character that ends an interval counts. Unknown: where that decides, a verdict is unresolved", &pref_sis_tza_from, choices_sis_tza_from, FALSE);
    prefs_register_uint_preference(module, "trs_ms", "TrS in ms", "Longest reaction time allowed; 0: as the bus was told", 10, &pref_sis_trs_ms);
    prefs_register_bool_preference(module, "tcp_heuristic", "Recognize SIS on any TCP port", "Where a segment starts with a whole telegram: equal lengths, right checksum; or with a command of the ASCII protocol", &pref_sis_tcp_heuristic);
    prefs_register_bool_preference(module, "udp_heuristic", "Recognize SIS on any UDP port", "The same for a datagram. Process data of a PPC may look like a telegram by chance", &pref_sis_udp_heuristic);
}

void
protocol_register_3964r(void)
{
    static hf_register_info fields[] = {
        {&hf_3964r_character, {"Character", "3964r.character", FT_UINT8, BASE_HEX, VALS(sis_procedure_characters), 0, "A single character of the procedure", HFILL}},
        {&hf_3964r_meaning, {"Meaning", "3964r.meaning", FT_UINT8, BASE_DEC, VALS(sis_procedure_meanings), 0, "From what came before", HFILL}},
        {&hf_3964r_length, {"Length of the data", "3964r.length", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_3964r_length), 0, "Without doubled DLEs", HFILL}},
        {&hf_3964r_doubled, {"Doubled DLEs", "3964r.doubled", FT_UINT32, BASE_DEC, NULL, 0, "DLEs in the data that were sent twice, so that no data look like an end", HFILL}},
        {&hf_3964r_end, {"End (DLE ETX)", "3964r.end", FT_UINT16, BASE_HEX, NULL, 0, "Marks the end of the block; the block check character follows", HFILL}},
        {&hf_3964r_bcc, {"Block check character", "3964r.bcc", FT_UINT8, BASE_HEX, NULL, 0, "XOR of all bytes after STX, with doubled DLEs, DLE and ETX", HFILL}},
        {&hf_3964r_bcc_status, {"Status of the block check character", "3964r.bcc.status", FT_UINT8, BASE_NONE, VALS(sis_checksum_states), 0, "Whether the block check character fits; unverified if bytes are missing", HFILL}},
        {&hf_3964r_data, {"Data", "3964r.data", FT_BYTES, BASE_NONE, NULL, 0, "The data of the block, without doubled DLEs", HFILL}},
        {&hf_3964r_raw, {"Not decoded", "3964r.raw", FT_BYTES, BASE_NONE, NULL, 0, "Bytes that do not fit the procedure", HFILL}},
        {&hf_3964r_answers, {"Answer to", "3964r.answers", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_REQUEST), 0, "The packet that this character or block answers", HFILL}},
        {&hf_3964r_answer_in, {"Answered in", "3964r.answer_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RESPONSE), 0, "The packet that answers this one", HFILL}},
        {&hf_3964r_answer_time, {"Answered after", "3964r.answer_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "From the last character of what it answers", HFILL}},
        {&hf_3964r_try, {"Try", "3964r.try", FT_UINT32, BASE_DEC, NULL, 0, "To connect, or to send this block", HFILL}},
        {&hf_3964r_repeat_of, {"Repeat of", "3964r.repeat_of", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RETRANS_PREV), 0, "The packet with the same block before", HFILL}},
        {&hf_3964r_unanswered_before, {"Before, not answered", "3964r.unanswered_before", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet that got no answer before this one came", HFILL}},
        {&hf_3964r_qvz_limit, {"QVZ (longest time to an answer)", "3964r.qvz.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Acknowledgment delay: after it the partner tries again", HFILL}},
        {&hf_3964r_qvz_verdict, {"Verdict on QVZ", "3964r.qvz.verdict", FT_UINT8, BASE_DEC, VALS(sis_procedure_verdicts), 0, "Whether the answer came in time, with the uncertainty of its time", HFILL}},
        {&hf_3964r_zvz_interval_max, {"Longest interval", "3964r.zvz.interval_max", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Between two characters of the block", HFILL}},
        {&hf_3964r_zvz_position, {"Longest interval before character", "3964r.zvz.position", FT_UINT32, BASE_DEC, NULL, 0, "Its number in the block, from 1", HFILL}},
        {&hf_3964r_zvz_limit, {"ZVZ (longest interval allowed)", "3964r.zvz.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Character delay: after it the receiver gives the block up", HFILL}},
        {&hf_3964r_zvz_verdict, {"Verdict on ZVZ", "3964r.zvz.verdict", FT_UINT8, BASE_DEC, VALS(sis_procedure_verdicts), 0, "Whether the intervals in the block keep ZVZ, with the uncertainty of their times", HFILL}},
    };
    static ei_register_info experts[] = {
        {&ei_3964r_bcc_bad, {"3964r.bcc.bad", PI_CHECKSUM, PI_ERROR, "Wrong block check character: the receiver answers NAK", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "A byte of the block was changed or lost. Look at line errors and losses at this packet. The receiver should answer NAK, and the block comes again.", HFILL}}}},
        {&ei_3964r_broken, {"3964r.broken", PI_MALFORMED, PI_WARN, "The block does not end with DLE ETX BCC, or a DLE in it is not doubled", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The block was cut, or damaged at a DLE. Look at line errors and losses at this packet, and at the pause after it.", HFILL}}}},
        {&ei_3964r_conflict, {"3964r.conflict", PI_SEQUENCE, PI_NOTE, "Both partners ask at once: the one with low priority gives way", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "Both partners wanted to send at the same time. Once is harmless. If it comes often, check that one partner has high and one low priority.", HFILL}}}},
        {&ei_3964r_unexpected, {"3964r.unexpected", PI_SEQUENCE, PI_NOTE, "There is nothing that this could answer", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "Nothing before it asks for this character. Look at the packets before it. The capture may have begun later.", HFILL}}}},
        {&ei_3964r_refused, {"3964r.refused", PI_RESPONSE_CODE, PI_NOTE, "The partner refuses", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The partner answered NAK. Look whether the block was damaged. If not, the partner is not ready.", HFILL}}}},
        {&ei_3964r_repeat, {"3964r.repeat", PI_SEQUENCE, PI_NOTE, "The same block again", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The sender sends the block again, because it was refused or not acknowledged. Look at the answer to the block before.", HFILL}}}},
        {&ei_3964r_unanswered, {"3964r.unanswered", PI_SEQUENCE, PI_NOTE, "Nobody answered what came before", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The partner said nothing in time. Check that the partner runs, and its cable.", HFILL}}}},
        {&ei_3964r_tries, {"3964r.tries", PI_SEQUENCE, PI_WARN, "More tries than 3964R has", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "A sender gives up after six tries. Check the settings of the sender.", HFILL}}}},
        {&ei_3964r_exceeded, {"3964r.exceeded", PI_PROTOCOL, PI_WARN, "A time of the procedure is exceeded", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "A partner was slower than the procedure allows. Look which partner was slow. Compare ZVZ and QVZ of both.", HFILL}}}},
        {&ei_3964r_unresolved, {"3964r.unresolved", PI_PROTOCOL, PI_NOTE, "A time of the procedure is perhaps exceeded", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The time may be too long or not: it is not exact enough. Make the tap more exact: sistap doctor says how.", HFILL}}}},
    };
    static int *subtrees[] = {&ett_3964r};
    module_t *module;

    proto_3964r = proto_register_protocol("3964R procedure", "3964R", "3964r");
    proto_register_field_array(proto_3964r, fields, array_length(fields));
    expert_register_field_array(expert_register_protocol(proto_3964r), experts, array_length(experts));
    proto_register_subtree_array(subtrees, array_length(subtrees));
    module = prefs_register_protocol(proto_3964r, NULL);
    prefs_register_uint_preference(module, "zvz_ms", "ZVZ in ms", "Longest interval between two characters of a block; 0: no verdict", 10, &pref_3964r_zvz_ms);
    prefs_register_uint_preference(module, "qvz_ms", "QVZ in ms", "Longest time to the partner's answer; 0: no verdict", 10, &pref_3964r_qvz_ms);
}

void
protocol_register_rk512i(void)
{
    static hf_register_info fields[] = {
        {&hf_rk512i_follow_up, {"Telegram", "rk512i.follow_up", FT_UINT8, BASE_HEX, VALS(sis_rk512_telegrams), 0, "The first telegram of a transfer, or one that continues it", HFILL}},
        {&hf_rk512i_zero, {"Always 0", "rk512i.zero", FT_UINT8, BASE_HEX, NULL, 0, "The second byte of every telegram", HFILL}},
        {&hf_rk512i_command, {"Command", "rk512i.command", FT_UINT8, BASE_HEX, VALS(sis_rk512_commands), 0, "SEND writes to the partner, FETCH reads from it", HFILL}},
        {&hf_rk512i_kind, {"Kind of data", "rk512i.kind", FT_UINT8, BASE_HEX, VALS(sis_rk512_kinds), 0, "What is accessed; SYNAX has data blocks only", HFILL}},
        {&hf_rk512i_block, {"Data block", "rk512i.block", FT_UINT8, BASE_DEC, NULL, 0, "Number of the data block in the PLC", HFILL}},
        {&hf_rk512i_block_word, {"Word", "rk512i.block.word", FT_UINT16, BASE_HEX, NULL, 0, "Of a data block", HFILL}},
        {&hf_rk512i_word, {"Data word", "rk512i.word", FT_UINT8, BASE_DEC, NULL, 0, "First word in the data block", HFILL}},
        {&hf_rk512i_count, {"Count", "rk512i.count", FT_UINT16, BASE_DEC, NULL, 0, "Words of data blocks, timers and counters, else bytes", HFILL}},
        {&hf_rk512i_flag_byte, {"Byte of the coordination flag", "rk512i.flag_byte", FT_UINT8, BASE_HEX, NULL, 0, "Byte of the PLC's flag that locks the block; FF: none", HFILL}},
        {&hf_rk512i_flag, {"Bit and CPU of the coordination flag", "rk512i.flag", FT_UINT8, BASE_HEX, NULL, 0, "Bits 0 to 3: bit of the flag, bits 4 to 7: CPU; FF: none", HFILL}},
        {&hf_rk512i_error, {"Error number", "rk512i.error", FT_UINT8, BASE_HEX, VALS(sis_rk512_errors), 0, "Siemens' numbers; the table that SYNAX has is lost", HFILL}},
        {&hf_rk512i_data, {"Data", "rk512i.data", FT_BYTES, BASE_NONE, NULL, 0, "The data of this telegram", HFILL}},
    };
    static int *subtrees[] = {&ett_rk512i, &ett_rk512i_whole};

    proto_rk512i = proto_register_protocol("RK512 with the Indramat extension", "RK512I", "rk512i");
    proto_register_field_array(proto_rk512i, fields, array_length(fields));
    proto_register_subtree_array(subtrees, array_length(subtrees));
}

void
protocol_register_arcnet7f(void)
{
    static hf_register_info fields[] = {
        {&hf_arcnet7f_id, {"Protocol", "arcnet7f.id", FT_UINT8, BASE_HEX, NULL, 0, "Always 0x7F", HFILL}},
        {&hf_arcnet7f_message, {"Message number", "arcnet7f.message", FT_UINT16, BASE_HEX, NULL, 0, "0x8010, in follow-ups 0x1c20 to 0x1cff", HFILL}},
        {&hf_arcnet7f_command, {"Command", "arcnet7f.command", FT_UINT8, BASE_DEC, VALS(sis_arcnet7f_commands), 0, "An answer is a TO", HFILL}},
        {&hf_arcnet7f_type, {"Data type", "arcnet7f.type", FT_UINT8, BASE_DEC, VALS(sis_arcnet7f_types), 0, "How the data are counted", HFILL}},
        {&hf_arcnet7f_length, {"Length in words", "arcnet7f.length", FT_UINT16, BASE_DEC, NULL, 0, "Of what follows it", HFILL}},
        {&hf_arcnet7f_block, {"Data block", "arcnet7f.block", FT_UINT8, BASE_DEC, NULL, 0, "Number of the data block", HFILL}},
        {&hf_arcnet7f_word, {"Word", "arcnet7f.word", FT_UINT16, BASE_HEX, NULL, 0, "Of a data block", HFILL}},
        {&hf_arcnet7f_list_actual, {"Actual length of the list", "arcnet7f.list.actual", FT_UINT16, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_arcnet7f_list_actual), 0, "Bytes that the list has now", HFILL}},
        {&hf_arcnet7f_list_maximum, {"Maximum length of the list", "arcnet7f.list.maximum", FT_UINT16, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_arcnet7f_list_maximum), 0, "Bytes that the list can have", HFILL}},
        {&hf_arcnet7f_first_in, {"Follows the telegram in", "arcnet7f.first_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet whose data this telegram continues", HFILL}},
    };
    static int *subtrees[] = {&ett_arcnet7f};

    proto_arcnet7f = proto_register_protocol("Rexroth SYNAX200 on ARCNET", "ARCNET7F", "arcnet7f");
    proto_register_field_array(proto_arcnet7f, fields, array_length(fields));
    proto_register_subtree_array(subtrees, array_length(subtrees));
}

void
protocol_register_synax(void)
{
    static hf_register_info fields[] = {
        {&hf_synax_request_in, {"Request in", "synax.request_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_REQUEST), 0, "The packet that this answer belongs to", HFILL}},
        {&hf_synax_answer_in, {"Answer in", "synax.answer_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RESPONSE), 0, "The packet that answers this request", HFILL}},
        {&hf_synax_answer_time, {"Time to the answer", "synax.answer_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "From the request to its answer", HFILL}},
        {&hf_synax_next_request_in, {"Next request in", "synax.next_request_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "Where nobody read an answer before it", HFILL}},
        {&hf_synax_unanswered_in, {"Request before, not answered", "synax.unanswered_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet with the request that got no answer", HFILL}},
        {&hf_synax_info, {"Info access", "synax.info", FT_UINT16, BASE_HEX, NULL, 0, "Read or write, and whether more follows; the other bits are not defined", HFILL}},
        {&hf_synax_info_open, {"Not defined", "synax.info.open", FT_UINT16, BASE_HEX, NULL, 0xFFFC, "Bits that no document explains", HFILL}},
        {&hf_synax_info_last, {"Last transmission", "synax.info.last", FT_BOOLEAN, 16, NULL, 0x0002, "Whether this is the last transmission", HFILL}},
        {&hf_synax_info_write, {"Write", "synax.info.write", FT_BOOLEAN, 16, NULL, 0x0001, "Set: write. Not set: read", HFILL}},
        {&hf_synax_axis, {"Axis", "synax.axis", FT_UINT8, BASE_DEC, NULL, 0, "Drive, 0: none; with a data block its number", HFILL}},
        {&hf_synax_pieces, {"Pieces", "synax.pieces", FT_NONE, BASE_NONE, NULL, 0, "The telegrams that carry the pieces of these data", HFILL}},
        {&hf_synax_pieces_piece, {"Piece", "synax.pieces.piece", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet with this piece", HFILL}},
        {&hf_synax_pieces_overlap, {"Overlap", "synax.pieces.overlap", FT_BOOLEAN, BASE_NONE, NULL, 0, "This piece repeats bytes of another", HFILL}},
        {&hf_synax_pieces_overlap_conflict, {"Overlap with other data", "synax.pieces.overlap.conflict", FT_BOOLEAN, BASE_NONE, NULL, 0, "This piece repeats bytes of another with other contents", HFILL}},
        {&hf_synax_pieces_multiple_tails, {"Several last pieces", "synax.pieces.multiple_tails", FT_BOOLEAN, BASE_NONE, NULL, 0, "More than one piece says that it is the last", HFILL}},
        {&hf_synax_pieces_too_long, {"Piece too long", "synax.pieces.too_long", FT_BOOLEAN, BASE_NONE, NULL, 0, "This piece goes beyond the end of the data", HFILL}},
        {&hf_synax_pieces_error, {"Error while putting together", "synax.pieces.error", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet in which the pieces did not fit", HFILL}},
        {&hf_synax_pieces_count, {"Number of pieces", "synax.pieces.count", FT_UINT32, BASE_DEC, NULL, 0, "How many telegrams carry these data", HFILL}},
        {&hf_synax_pieces_whole_in, {"The whole is in", "synax.pieces.whole_in", FT_FRAMENUM, BASE_NONE, NULL, 0, "The packet that shows the joined data", HFILL}},
        {&hf_synax_pieces_length, {"Length of the whole", "synax.pieces.length", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&unit_synax_pieces_length), 0, "Bytes of the joined data", HFILL}},
    };
    static ei_register_info experts[] = {
        {&ei_synax_note, {"synax.note", PI_PROTOCOL, PI_NOTE, "Content that the documents do not define", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The documents do not define this value, or leave its meaning open. Read the text of the item.", HFILL}}}},
        {&ei_synax_short, {"synax.short", PI_PROTOCOL, PI_WARN, "Bytes are missing", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The data end before all fields are there. Compare the telegram with its layout.", HFILL}}}},
        {&ei_synax_unexpected, {"synax.unexpected", PI_PROTOCOL, PI_WARN, "More bytes than expected", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "Bytes follow that the telegram does not have. Compare the telegram with its layout.", HFILL}}}},
        {&ei_synax_error, {"synax.error", PI_RESPONSE_CODE, PI_NOTE, "The answer reports an error", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The partner could not do what it was asked for. Read the error number.", HFILL}}}},
        {&ei_synax_failed, {"synax.failed", PI_RESPONSE_CODE, PI_WARN, "The fieldbus has failed", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "Bit 3 of object 5FF2 is 0: the control has lost its fieldbus. Check the plugs, the cable and the master of the fieldbus. Object 5FF0 has a code for its fault.", HFILL}}}},
        {&ei_synax_unanswered, {"synax.unanswered", PI_SEQUENCE, PI_NOTE, "No answer before the next request", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The next request came before an answer. Look whether the partner runs, and how long its answers take at other times.", HFILL}}}},
        {&ei_synax_unanswered_before, {"synax.unanswered_before", PI_SEQUENCE, PI_NOTE, "A request before this one got no answer", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The request before this one got no answer. Look whether the partner runs, and how long its answers take at other times.", HFILL}}}},
        {&ei_synax_pieces_too_many, {"synax.pieces.too_many", PI_SEQUENCE, PI_NOTE, "More than 8192 pieces: they are not joined", 0, NULL, 0, {0, {NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, "The transfer is longer than any that the documents allow. Look at the pieces one by one.", HFILL}}}},
    };
    static int *subtrees[] = {&ett_synax, &ett_synax_info, &ett_synax_pieces, &ett_synax_piece};

    proto_synax = proto_register_protocol("Rexroth SYNAX200 transports", "SYNAX", "synax");
    proto_register_field_array(proto_synax, fields, array_length(fields));
    expert_register_field_array(expert_register_protocol(proto_synax), experts, array_length(experts));
    proto_register_subtree_array(subtrees, array_length(subtrees));
}

void
protocol_register_synaxpk(void)
{
    static hf_register_info fields[] = {
        {&hf_synaxpk_word, {"Control or status word", "synaxpk.word", FT_UINT16, BASE_HEX, NULL, 0, "FBSteuer of the master, FBStatus of the slave", HFILL}},
        {&hf_synaxpk_word_open, {"Not defined", "synaxpk.word.open", FT_UINT16, BASE_HEX, NULL, 0xC000, "Bits that no document explains. In the short format 3 the bit Control 1 is always set: its place is not known (SYNAX p. 3-20)", HFILL}},
        {&hf_synaxpk_word_error, {"Error", "synaxpk.word.error", FT_BOOLEAN, 16, NULL, 0x2000, "Of the slave; of the master: clear the error", HFILL}},
        {&hf_synaxpk_word_read, {"Access to the channel", "synaxpk.word.read", FT_BOOLEAN, 16, TFS(&texts_synaxpk_word_read), 0x1000, "An order is written and its answer read, that of writing a parameter, too", HFILL}},
        {&hf_synaxpk_word_busy, {"Bit 11 (busy)", "synaxpk.word.busy", FT_BOOLEAN, 16, NULL, 0x0800, "Not certain", HFILL}},
        {&hf_synaxpk_word_last, {"Last fragment", "synaxpk.word.last", FT_BOOLEAN, 16, NULL, 0x0400, "Whether this is the last fragment of the telegram", HFILL}},
        {&hf_synaxpk_word_bit9, {"Bit 9 (handshake)", "synaxpk.word.bit9", FT_BOOLEAN, 16, NULL, 0x0200, "Not certain", HFILL}},
        {&hf_synaxpk_word_toggle, {"Toggle", "synaxpk.word.toggle", FT_BOOLEAN, 16, NULL, 0x0100, "The master changes it each cycle, and the slave copies it", HFILL}},
        {&hf_synaxpk_word_count, {"Valid data bytes", "synaxpk.word.count", FT_UINT16, BASE_DEC, NULL, 0x00F0, "How many bytes after the word count", HFILL}},
        {&hf_synaxpk_word_format, {"Format", "synaxpk.word.format", FT_UINT16, BASE_HEX, VALS(sis_channel_formats), 0x000F, "The layout of the data after the word", HFILL}},
        {&hf_synaxpk_sender, {"Sender", "synaxpk.sender", FT_UINT8, BASE_DEC, VALS(sis_channel_senders), 0, "Who has sent this word", HFILL}},
        {&hf_synaxpk_payload, {"Data of this packet", "synaxpk.payload", FT_BYTES, BASE_NONE, NULL, 0, "The valid bytes after the word", HFILL}},
        {&hf_synaxpk_beyond, {"Not valid", "synaxpk.beyond", FT_BYTES, BASE_NONE, NULL, 0, "Bytes of the channel after the valid ones", HFILL}},
        {&hf_synaxpk_byte, {"Byte", "synaxpk.byte", FT_UINT8, BASE_HEX, NULL, 0, "Not defined", HFILL}},
        {&hf_synaxpk_class, {"Error class", "synaxpk.class", FT_UINT8, BASE_HEX, NULL, 0, "High byte of the error code", HFILL}},
        {&hf_synaxpk_class_code, {"Error code in its class", "synaxpk.class.code", FT_UINT8, BASE_HEX, NULL, 0, "Low byte of the error code", HFILL}},
        {&hf_synaxpk_code, {"Error of the channel", "synaxpk.code", FT_UINT16, BASE_HEX | BASE_RANGE_STRING, RVALS(sis_channel_codes), 0, "Why the channel refuses the request", HFILL}},
        {&hf_synaxpk_sis_length, {"Length (DatL)", "synaxpk.sis.length", FT_UINT8, BASE_DEC, NULL, 0, "Bytes of useful data of the SIS telegram", HFILL}},
        {&hf_synaxpk_sis_length_repeated, {"Length again (DatLW)", "synaxpk.sis.length_repeated", FT_UINT8, BASE_DEC, NULL, 0, "Must equal the length", HFILL}},
        {&hf_synaxpk_sis_control, {"Telegram control (Cntrl)", "synaxpk.sis.control", FT_UINT8, BASE_HEX, NULL, 0, "Direction of the SIS telegram", HFILL}},
        {&hf_synaxpk_sis_service, {"Service", "synaxpk.sis.service", FT_UINT8, BASE_HEX, NULL, 0, "SIS service in the channel", HFILL}},
        {&hf_synaxpk_drive, {"Control or status word", "synaxpk.drive", FT_UINT16, BASE_HEX, NULL, 0, "Of IndraDrive", HFILL}},
        {&hf_synaxpk_drive_pf, {"Ident of 4 bytes (PF)", "synaxpk.drive.pf", FT_BOOLEAN, 16, NULL, 0x8000, "Set: idents have 4 bytes. Not set: 2 bytes", HFILL}},
        {&hf_synaxpk_drive_error, {"G; in a status word F, error", "synaxpk.drive.error", FT_BOOLEAN, 16, NULL, 0x4000, "In a status word: the data are an error", HFILL}},
        {&hf_synaxpk_drive_last, {"Last fragment (L)", "synaxpk.drive.last", FT_BOOLEAN, 16, NULL, 0x2000, "Whether this is the last fragment", HFILL}},
        {&hf_synaxpk_drive_toggle, {"Toggle (T)", "synaxpk.drive.toggle", FT_BOOLEAN, 16, NULL, 0x1000, "Marks a new fragment", HFILL}},
        {&hf_synaxpk_drive_fragment, {"Bytes in this fragment (FL)", "synaxpk.drive.fragment", FT_UINT16, BASE_DEC, NULL, 0x0F00, "How many bytes of data this packet carries", HFILL}},
        {&hf_synaxpk_drive_length, {"Bytes left, with this fragment (GL)", "synaxpk.drive.length", FT_UINT16, BASE_DEC, NULL, 0x00FF, "How many bytes are still to come, these included", HFILL}},
        {&hf_synaxpk_index, {"Index", "synaxpk.index", FT_UINT16, BASE_HEX, NULL, 0, "0x2000 and the ident number of a parameter", HFILL}},
        {&hf_synaxpk_subindex, {"Subindex", "synaxpk.subindex", FT_UINT16, BASE_DEC, NULL, 0, "Element of the parameter; 7: operating data", HFILL}},
    };
    static int *subtrees[] = {&ett_synaxpk, &ett_synaxpk_word, &ett_synaxpk_raw};
    module_t *module;

    proto_synaxpk = proto_register_protocol("Rexroth SYNAX200 parameter channel", "SYNAXPK", "synaxpk");
    proto_register_field_array(proto_synaxpk, fields, array_length(fields));
    proto_register_subtree_array(subtrees, array_length(subtrees));
    module = prefs_register_protocol(proto_synaxpk, NULL);
    prefs_register_enum_preference(module, "layout", "Layout of the control and status word", "IndraDrive has a parameter channel of its own", &pref_synaxpk_layout, choices_synaxpk_layout, FALSE);
    prefs_register_enum_preference(module, "direction", "Sender", "Who has sent the packets: in a capture made at the master, what it sent comes from the master, and what it received from the slave", &pref_synaxpk_direction, choices_synaxpk_direction, FALSE);
}

void
protocol_register_synaxobj(void)
{
    static hf_register_info fields[] = {
        {&hf_synaxobj_index, {"Object", "synaxobj.index", FT_UINT16, BASE_HEX, VALS(sis_synaxobj_names), 0, "Which object is read or written", HFILL}},
        {&hf_synaxobj_operation, {"Operation", "synaxobj.operation", FT_UINT8, BASE_DEC, VALS(sis_synaxobj_operations), 0, "Read or write, request or answer", HFILL}},
        {&hf_synaxobj_raw, {"Raw", "synaxobj.raw", FT_BYTES, BASE_NONE, NULL, 0, "Bytes that are not decoded", HFILL}},
        {&hf_synaxobj_padding, {"Padding", "synaxobj.padding", FT_BYTES, BASE_NONE, NULL, 0, "What fills the object up after its telegram", HFILL}},
        {&hf_synaxobj_open_bit, {"Bit that is set and not defined", "synaxobj.open_bit", FT_UINT8, BASE_DEC, NULL, 0, "Number of a bit that no document explains", HFILL}},
        {&hf_synaxobj_diagnosis, {"Diagnosis fieldbus", "synaxobj.diagnosis", FT_UINT16, BASE_HEX, NULL, 0, "Fault code and interface of the fieldbus card", HFILL}},
        {&hf_synaxobj_diagnosis_interface, {"Interface", "synaxobj.diagnosis.interface", FT_UINT16, BASE_DEC, NULL, 0xF000, "Which is which is not defined", HFILL}},
        {&hf_synaxobj_diagnosis_fault, {"Fault code", "synaxobj.diagnosis.fault", FT_UINT16, BASE_HEX, NULL, 0x00FF, "Of the fieldbus, each has its own", HFILL}},
        {&hf_synaxobj_status, {"Status fieldbus", "synaxobj.status", FT_UINT16, BASE_HEX, NULL, 0, "State of the fieldbus card", HFILL}},
        {&hf_synaxobj_status_bus, {"Bus", "synaxobj.status.bus", FT_BOOLEAN, 16, TFS(&texts_synaxobj_status_bus), 0x0008, "Whether the fieldbus has failed", HFILL}},
        {&hf_synaxobj_status_memory, {"State of the dual-port RAM", "synaxobj.status.memory", FT_UINT16, BASE_DEC, NULL, 0x0003, "Which is which is not defined", HFILL}},
        {&hf_synaxobj_ppc, {"Word of the PPC", "synaxobj.ppc", FT_UINT16, BASE_HEX, NULL, 0, "Written by the PPC; no document explains it", HFILL}},
        {&hf_synaxobj_fault, {"Fault code PPC", "synaxobj.fault", FT_UINT16, BASE_HEX, NULL, 0, "The next valid access clears it", HFILL}},
        {&hf_synaxobj_fault_communication, {"Communication channel", "synaxobj.fault.communication", FT_UINT16, BASE_HEX, NULL, 0xFF00, "Fault code of the communication channel", HFILL}},
        {&hf_synaxobj_fault_process_data, {"Process data channel", "synaxobj.fault.process_data", FT_UINT16, BASE_HEX, NULL, 0x00FF, "Fault code of the process data channel", HFILL}},
    };
    static int *subtrees[] = {&ett_synaxobj, &ett_synaxobj_word};

    proto_synaxobj = proto_register_protocol("Rexroth SYNAX200 object", "SYNAXOBJ", "synaxobj");
    proto_register_field_array(proto_synaxobj, fields, array_length(fields));
    proto_register_subtree_array(subtrees, array_length(subtrees));
}

void
protocol_register_synaxpcp(void)
{
    static hf_register_info fields[] = {
        {&hf_synaxpcp_service, {"Service", "synaxpcp.service", FT_UINT16, BASE_HEX, VALS(sis_synaxpcp_services), 0, "What the telegram asks for or answers", HFILL}},
        {&hf_synaxpcp_count, {"Word count", "synaxpcp.count", FT_UINT16, BASE_DEC, NULL, 0, "Words after this one", HFILL}},
        {&hf_synaxpcp_invoke, {"Invoke id", "synaxpcp.invoke", FT_UINT8, BASE_DEC, NULL, 0, "Tells requests apart that wait at the same time", HFILL}},
        {&hf_synaxpcp_reference, {"Communication reference", "synaxpcp.reference", FT_UINT8, BASE_DEC, NULL, 0, "Which device", HFILL}},
        {&hf_synaxpcp_index, {"Index", "synaxpcp.index", FT_UINT16, BASE_HEX, NULL, 0, "Which object", HFILL}},
        {&hf_synaxpcp_index_of_request, {"Index of the request", "synaxpcp.index_of_request", FT_UINT16, BASE_HEX, NULL, 0, "An answer does not name its object", HFILL}},
        {&hf_synaxpcp_subindex, {"Subindex", "synaxpcp.subindex", FT_UINT8, BASE_DEC, NULL, 0, "Which element of it, 0: the whole", HFILL}},
        {&hf_synaxpcp_length, {"Length", "synaxpcp.length", FT_UINT8, BASE_DEC, NULL, 0, "Bytes of data", HFILL}},
        {&hf_synaxpcp_data, {"Data", "synaxpcp.data", FT_BYTES, BASE_NONE, NULL, 0, "What is read or written", HFILL}},
        {&hf_synaxpcp_padding, {"Padding", "synaxpcp.padding", FT_BYTES, BASE_NONE, NULL, 0, "What fills up a word", HFILL}},
        {&hf_synaxpcp_result, {"Result", "synaxpcp.result", FT_UINT16, BASE_HEX, NULL, 0, "0: done", HFILL}},
        {&hf_synaxpcp_error, {"Error", "synaxpcp.error", FT_UINT32, BASE_HEX, NULL, 0, "Error class, error code and additional code as one number", HFILL}},
        {&hf_synaxpcp_error_class, {"Error class", "synaxpcp.error.class", FT_UINT8, BASE_DEC, NULL, 0, "Kind of the error", HFILL}},
        {&hf_synaxpcp_error_code, {"Error code", "synaxpcp.error.code", FT_UINT8, BASE_DEC, NULL, 0, "The error in its class", HFILL}},
        {&hf_synaxpcp_error_additional, {"Additional code", "synaxpcp.error.additional", FT_UINT16, BASE_HEX, NULL, 0, "More about the error; the device defines it", HFILL}},
        {&hf_synaxpcp_raw, {"Raw", "synaxpcp.raw", FT_BYTES, BASE_NONE, NULL, 0, "Bytes that are not decoded", HFILL}},
        {&hf_synaxpcp_request_in, {"Request in", "synaxpcp.request_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_REQUEST), 0, "The packet that this response answers", HFILL}},
        {&hf_synaxpcp_response_in, {"Response in", "synaxpcp.response_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RESPONSE), 0, "The packet that answers this request", HFILL}},
        {&hf_synaxpcp_response_time, {"Time to the response", "synaxpcp.response_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "From the request to its response", HFILL}},
    };
    static int *subtrees[] = {&ett_synaxpcp, &ett_synaxpcp_error};

    proto_synaxpcp = proto_register_protocol("Interbus PCP", "SYNAXPCP", "synaxpcp");
    proto_register_field_array(proto_synaxpcp, fields, array_length(fields));
    proto_register_subtree_array(subtrees, array_length(subtrees));
}

void
protocol_register_synaxpd(void)
{
    static hf_register_info fields[] = {
        {&hf_synaxpd_direction, {"Direction", "synaxpd.direction", FT_UINT8, BASE_DEC, VALS(sis_synaxpd_directions), 0, "Known where one port is among those of preference synaxpd.ports", HFILL}},
        {&hf_synaxpd_word, {"Word", "synaxpd.word", FT_UINT16, BASE_HEX, NULL, 0, "A word of process data; parameters of the PPC define what it means", HFILL}},
        {&hf_synaxpd_value, {"Value", "synaxpd.value", FT_STRING, BASE_NONE, NULL, 0, "As the table of process data names it", HFILL}},
        {&hf_synaxpd_raw, {"Raw", "synaxpd.raw", FT_BYTES, BASE_NONE, NULL, 0, "Bytes that are no word", HFILL}},
    };
    static int *subtrees[] = {&ett_synaxpd, &ett_synaxpd_value};
    module_t *module;

    proto_synaxpd = proto_register_protocol("Rexroth SYNAX200 process data", "SYNAXPD", "synaxpd");
    proto_register_field_array(proto_synaxpd, fields, array_length(fields));
    proto_register_subtree_array(subtrees, array_length(subtrees));
    module = prefs_register_protocol(proto_synaxpd, NULL);
    range_convert_str(wmem_epan_scope(), &pref_synaxpd_ports, "", MOST_PORT);
    prefs_register_range_preference(module, "ports", "UDP ports of the PPC", "Those of parameter C-0-0194; none is known by itself", &pref_synaxpd_ports, MOST_PORT);
    prefs_register_bool_preference(module, "swap_bytes", "Bytes of a word are swapped", "As bits of C-0-0129 say", &pref_synaxpd_swap_bytes);
    prefs_register_bool_preference(module, "swap_words", "Words of a double word are swapped", "As bits of C-0-0129 say", &pref_synaxpd_swap_words);
}

void
protocol_register_sisascii(void)
{
    static hf_register_info fields[] = {
        {&hf_sisascii_kind, {"Line", "sisascii.kind", FT_UINT8, BASE_DEC, VALS(sis_ascii_kinds), 0, "What a line of the ASCII protocol is", HFILL}},
        {&hf_sisascii_drive, {"Drive", "sisascii.drive", FT_UINT8, BASE_DEC, NULL, 0, "Address of the drive that is opened, or that shows its prompt; of other lines: of the drive that is open", HFILL}},
        {&hf_sisascii_element, {"Element", "sisascii.element", FT_UINT8, BASE_DEC, VALS(sis_elements), 0, "Which part of a parameter is read or written", HFILL}},
        {&hf_sisascii_index, {"Number in the list", "sisascii.index", FT_UINT32, BASE_DEC, NULL, 0, "Which element of a list this is, from 1", HFILL}},
        {&hf_sisascii_text, {"Text", "sisascii.text", FT_STRING, BASE_NONE, NULL, 0, "The characters of a line that is no command", HFILL}},
    };
    static int *subtrees[] = {&ett_sisascii};

    proto_sisascii = proto_register_protocol("Rexroth ASCII protocol", "SISASCII", "sisascii");
    proto_register_field_array(proto_sisascii, fields, array_length(fields));
    proto_register_subtree_array(subtrees, array_length(subtrees));
}
