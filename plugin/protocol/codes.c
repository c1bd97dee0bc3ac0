/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The codes of all protocols, and their texts.
 * Made by generate.py from codes.toml: edit there. */
/* clang-format off */

#include "protocol/codes.h"

const range_string sis_services[] = {
    {0x00, 0x00, "Node identification"},
    {0x01, 0x01, "Cancel data transmission"},
    {0x02, 0x02, "Flash operation"},
    {0x03, 0x03, "Initialization of the SIS communication"},
    {0x04, 0x04, "Execute a list of SIS services"},
    {0x0F, 0x0F, "Token passing"},
    {0x10, 0x10, "Read parameter"},
    {0x11, 0x11, "Read list segment"},
    {0x12, 0x12, "Read phase"},
    {0x1D, 0x1D, "Switch phase"},
    {0x1E, 0x1E, "Write list segment"},
    {0x1F, 0x1F, "Write parameter"},
    {0x80, 0x80, "Read parameter (ECODRIVE)"},
    {0x81, 0x81, "Read list segment (ECODRIVE)"},
    {0x8E, 0x8E, "Write list segment (ECODRIVE)"},
    {0x8F, 0x8F, "Write parameter (ECODRIVE)"},
    {0x90, 0x90, "Read parameter (SYNAX)"},
    {0x91, 0x91, "Read list segment (SYNAX)"},
    {0x92, 0x92, "Read phase (SYNAX)"},
    {0x9D, 0x9D, "Switch phase (SYNAX)"},
    {0x9E, 0x9E, "Write list segment (SYNAX)"},
    {0x9F, 0x9F, "Write parameter (SYNAX)"},
    {0x00, 0x0F, "General service"},
    {0x10, 0x7F, "Reserved service"},
    {0x80, 0x8F, "ECODRIVE service"},
    {0x90, 0x9F, "SYNAX service"},
    {0xA0, 0xAF, "MT-CNC/MTC200 service"},
    {0xB0, 0xBF, "ISP200 service"},
    {0xC0, 0xCF, "CLC-GPS service"},
    {0xD0, 0xDF, "HMI system service"},
    {0xE0, 0xEF, "DISC service"},
    {0xF0, 0xFF, "Reserved service"},
    {0, 0, NULL},
};

const value_string sis_address_kinds[] = {
    {SIS_STATION, "station"},
    {SIS_SERVICE_MASTER, "service or emergency master"},
    {SIS_POINT_TO_POINT, "point-to-point"},
    {SIS_NOT_ASSIGNED, "not assigned"},
    {SIS_RESERVED, "reserved"},
    {SIS_NO_SENDER, "not a sender address"},
    {SIS_GROUP, "logical group"},
    {SIS_LEVEL_BROADCAST, "broadcast on one hierarchy level"},
    {SIS_GLOBAL_BROADCAST, "global broadcast"},
    {0, NULL},
};

const value_string sis_command_kinds[] = {
    {0x00, "FETCH"},
    {0x03, "SEND"},
    {0x10, "FETCH"},
    {0x11, "FETCH"},
    {0x12, "FETCH"},
    {0x1D, "SEND"},
    {0x1E, "SEND"},
    {0x1F, "SEND"},
    {0, NULL},
};

const value_string sis_message_kinds[] = {
    {6, "group message, no reaction"},
    {7, "broadcast message, no reaction"},
    {8, "broadcast message, no reaction"},
    {0, NULL},
};

const value_string sis_control_status_ecodrive03[] = {
    {0, "No error, request processed"},
    {1, "Request still being processed"},
    {2, "Request cannot be processed now"},
    {3, "Not defined"},
    {4, "Warning"},
    {5, "Not defined"},
    {6, "Error"},
    {7, "Not defined"},
    {0, NULL},
};

const range_string sis_status[] = {
    {0x00, 0x00, "Transmission error-free"},
    {0x01, 0x01, "Execution error"},
    {0x02, 0x02, "Error in the internal transmission channel"},
    {0x03, 0xEF, "Execution error, not specified"},
    {0xF0, 0xF0, "Invalid service"},
    {0xF1, 0xF1, "Invalid telegram"},
    {0xF2, 0xF2, "Wrong telegram length"},
    {0xF3, 0xF3, "Telegram error, not specified"},
    {0xF4, 0xF4, "Wrong checksum"},
    {0xF5, 0xF7, "Telegram error, not specified"},
    {0xF8, 0xF8, "Invalid sequential telegram"},
    {0xF9, 0xF9, "Command has subaddresses, the slave does not route"},
    {0xFA, 0xFA, "Useful data missing in the command"},
    {0xFB, 0xFB, "Subservice not supported"},
    {0xFC, 0xFC, "Component not available or address invalid"},
    {0xFD, 0xFF, "Telegram error, not specified"},
    {0, 0, NULL},
};

const value_string sis_status_phase[] = {
    {0x01, "Execution error, not specified for this service"},
    {0x02, "Phase switching error"},
    {0, NULL},
};

const value_string sis_errors_channel[] = {
    {0x8001, "Transmission channel busy"},
    {0x8002, "Fault in the transmission channel"},
    {0x800B, "Transmission cancelled, another request had priority"},
    {0x800C, "Access not allowed, the transmission channel is still active"},
    {0, NULL},
};

const value_string sis_advice_channel[] = {
    {0x8001, "repeat the command until the channel is free"},
    {0x8002, "repeat the command to see whether the fault lasts"},
    {0x800B, "repeat the command until it is executed without being cancelled"},
    {0x800C, "repeat the command until the active request has ended"},
    {0, NULL},
};

const value_string sis_subservices_identification[] = {
    {0x01, "SIS version"},
    {0x02, "Firmware (FWA) number"},
    {0x03, "Device type key"},
    {0x04, "Supported baud rates"},
    {0, NULL},
};

const value_string sis_subservices_flash[] = {
    {0x90, "Shutdown"},
    {0x91, "Reboot"},
    {0x92, "Read flash"},
    {0x93, "Find header"},
    {0x94, "Erase flash"},
    {0x96, "Program flash"},
    {0x97, "Build checksum"},
    {0x9F, "Reset errors in the slave"},
    {0, NULL},
};

const value_string sis_errors_flash[] = {
    {0x9002, "Firmware was deleted"},
    {0x9003, "Shutdown not allowed in phase 3"},
    {0x9004, "Shutdown not allowed in phase 4"},
    {0x9010, "Shutdown not allowed in operating mode"},
    {0x9102, "Firmware was deleted"},
    {0x9103, "Reboot not allowed in phase 3"},
    {0x9104, "Reboot not allowed in phase 4"},
    {0x9110, "Reboot not allowed in operating mode"},
    {0x9200, "Read error"},
    {0x920B, "More than the maximum of useful data"},
    {0x9400, "Timeout while erasing"},
    {0x940A, "Erasing is only possible in the loader"},
    {0x96E0, "Verify error while programming the flash"},
    {0x96E1, "Timeout while programming the flash"},
    {0x96FF, "Error while writing to the RAM"},
    {0x9701, "Additive checksum wrong"},
    {0x9702, "CRC32 checksum wrong"},
    {0, NULL},
};

const value_string sis_shutdown_targets[] = {
    {0x00, "Firmware"},
    {0x01, "Loader"},
    {0, NULL},
};

const value_string sis_device_types[] = {
    {0x00, "None (not supported)"},
    {0x01, "ROM (not supported)"},
    {0x02, "RAM"},
    {0x03, "Dual-port RAM"},
    {0x04, "Flash"},
    {0, NULL},
};

const value_string sis_subservices_initialization[] = {
    {SIS_SET_TRS, "Set TrS (slave reaction time)"},
    {SIS_SET_TZA, "Set TzA (character interval)"},
    {SIS_SET_TMAS, "Set Tmas (master control word cycle)"},
    {0x06, "Assign multicast group"},
    {SIS_SET_BAUD_RATE, "Set baud rate"},
    {SIS_TEST_BAUD, "Timed baud rate test"},
    {SIS_ACCEPT, "Accept the set values"},
    {0, NULL},
};

const value_string sis_errors_initialization[] = {
    {0x0700, "Baud rate not supported"},
    {0x0800, "Baud rate not supported"},
    {0x0801, "Test time too large for the internal timer"},
    {0, NULL},
};

const value_string sis_baud_masks[] = {
    {0x00, "9600"},
    {0x01, "19200"},
    {0x02, "38400"},
    {0x04, "57600"},
    {0x08, "115200"},
    {0, NULL},
};

const value_string sis_elements[] = {
    {0, "Channel not active"},
    {1, "Ident number"},
    {2, "Name"},
    {3, "Attribute"},
    {4, "Unit"},
    {5, "Minimum"},
    {6, "Maximum"},
    {7, "Operating data"},
    {0, NULL},
};

const value_string sis_errors_parameter[] = {
    {0x0000, "No error"},
    {0x0001, "Service channel not open"},
    {0x0009, "Wrong access to element 0"},
    {0x00A0, "Request not allowed"},
    {0x00B0, "Element not allowed"},
    {0x1001, "Ident number not available"},
    {0x1009, "Wrong access to element 1"},
    {0x2001, "Name not available"},
    {0x2002, "Name transmitted too short"},
    {0x2003, "Name transmitted too long"},
    {0x2004, "Name cannot be changed"},
    {0x2005, "Name is write-protected at present"},
    {0x3002, "Attribute transmitted too short"},
    {0x3003, "Attribute transmitted too long"},
    {0x3004, "Attribute cannot be changed"},
    {0x3005, "Attribute is write-protected at present"},
    {0x4001, "Unit not available"},
    {0x4002, "Unit transmitted too short"},
    {0x4003, "Unit transmitted too long"},
    {0x4004, "Unit cannot be changed"},
    {0x4005, "Unit is write-protected at present"},
    {0x5001, "Minimum not available"},
    {0x5002, "Minimum transmitted too short"},
    {0x5003, "Minimum transmitted too long"},
    {0x5004, "Minimum cannot be changed"},
    {0x5005, "Minimum is write-protected at present"},
    {0x6001, "Maximum not available"},
    {0x6002, "Maximum transmitted too short"},
    {0x6003, "Maximum transmitted too long"},
    {0x6004, "Maximum cannot be changed"},
    {0x6005, "Maximum is write-protected at present"},
    {0x7002, "Operating data transmitted too short"},
    {0x7003, "Operating data transmitted too long"},
    {0x7004, "Operating data cannot be changed"},
    {0x7005, "Operating data are write-protected at present"},
    {0x7006, "Operating data smaller than the minimum"},
    {0x7007, "Operating data greater than the maximum"},
    {0x7008, "Operating data not correct"},
    {0x700C, "Operating data outside the range: below zero, or above the modulo value of a modulo axis"},
    {0x700D, "The length of the operating data cannot be changed at present"},
    {0x700E, "The length of the operating data cannot be changed"},
    {0x700F, "List element not available, or the list offset is not the start of an element"},
    {0x8001, "Service channel busy"},
    {0x8002, "Failure in the service channel"},
    {0x800B, "Transmission cancelled, another request had priority"},
    {0x800C, "Service channel still active, or parameter occupied by a sequential transmission"},
    {0, NULL},
};

const value_string sis_advice_parameter[] = {
    {0x8001, "not done within the time-out, which C-0-0124 sets; nothing was transferred"},
    {0, NULL},
};

const value_string sis_errors_phase[] = {
    {0x8004, "Wrong phase requested over the serial protocol"},
    {0xD005, "Phase switch still active"},
    {0xD006, "Phase switch not allowed while a drive is enabled"},
    {0xD007, "Phase switch not allowed while the master axis turns"},
    {0, NULL},
};

const value_string sis_phases[] = {
    {2, "parameter mode"},
    {4, "operating mode"},
    {0, NULL},
};

const value_string sis_data_states[] = {
    {0x00, "not set"},
    {0x03, "done"},
    {0x05, "interrupted"},
    {0x07, "in process"},
    {0x0F, "execution not possible"},
    {0, NULL},
};

const value_string sis_parameter_types[] = {
    {0, "Parameter of a drive"},
    {1, "Control parameter, first kind (A)"},
    {2, "Control parameter, second kind (C)"},
    {0, NULL},
};

const value_string sis_attribute_lengths[] = {
    {0, "Not defined"},
    {1, "2 bytes"},
    {2, "4 bytes"},
    {3, "8 bytes"},
    {4, "List of single bytes"},
    {5, "List of 2-byte elements"},
    {6, "List of 4-byte elements"},
    {7, "List of 8-byte elements"},
    {0, NULL},
};

const value_string sis_attribute_formats[] = {
    {SIS_FORMAT_BINARY, "Binary"},
    {SIS_FORMAT_UNSIGNED, "Unsigned decimal"},
    {SIS_FORMAT_SIGNED, "Signed decimal"},
    {SIS_FORMAT_HEXADECIMAL, "Hexadecimal"},
    {SIS_FORMAT_TEXT, "Text"},
    {SIS_FORMAT_IDENT, "Ident number"},
    {SIS_FORMAT_FLOATING, "Floating point"},
    {SIS_FORMAT_TIME, "Time"},
    {0, NULL},
};

const value_string sis_sertap_types[] = {
    {SERTAP_FRAME, "Frame"},
    {SERTAP_OTHER, "Other characters"},
    {SERTAP_EVENT, "Event"},
    {SERTAP_BEFORE, "Frame from before this file"},
    {0, NULL},
};

const value_string sis_sertap_lines[] = {
    {0, "Shared bus"},
    {1, "First direction"},
    {2, "Second direction"},
    {0, NULL},
};

const value_string sis_sertap_parities[] = {
    {0, "None"},
    {1, "Even"},
    {2, "Odd"},
    {3, "Mark"},
    {4, "Space"},
    {0, NULL},
};

const value_string sis_sertap_stop_bits[] = {
    {2, "1"},
    {3, "1.5"},
    {4, "2"},
    {0, NULL},
};

const value_string sis_sertap_framings[] = {
    {0x00, "SIS"},
    {0x01, "3964R"},
    {0x02, "ASCII"},
    {0xFF, "Silence"},
    {0, NULL},
};

const value_string sis_sertap_events[] = {
    {0, "None"},
    {SERTAP_CAPTURE_STARTED, "Capture started"},
    {2, "Line settings changed"},
    {SERTAP_CHARACTERS_LOST, "Characters lost"},
    {SERTAP_ADAPTER_LOST, "Adapter lost"},
    {5, "Marker"},
    {SERTAP_LIMITS_TOLD, "Limits told by the user"},
    {7, "Told before"},
    {0, NULL},
};

const value_string sis_checksum_states[] = {
    {0, "Bad"},
    {1, "Good"},
    {2, "Unverified"},
    {0, NULL},
};

const value_string sis_verdicts[] = {
    {SIS_TIME_OK, "ok"},
    {SIS_TIME_EXCEEDED, "exceeded"},
    {SIS_TIME_UNRESOLVED, "unresolved: the times do not decide"},
    {0, NULL},
};

const value_string sis_procedure_meanings[] = {
    {P3964R_ASKS, "asks to send"},
    {P3964R_BOTH_ASK, "asks to send, as the partner does: the one with low priority gives way"},
    {P3964R_GRANTS, "ready to receive"},
    {P3964R_REFUSES_REQUEST, "not ready to receive"},
    {P3964R_BLOCK, "block"},
    {P3964R_ACKNOWLEDGES, "block received"},
    {P3964R_REFUSES_BLOCK, "block refused: it comes again"},
    {P3964R_OUT_OF_PLACE, "nothing to answer"},
    {0, NULL},
};

const value_string sis_procedure_characters[] = {
    {P3964R_STX, "STX"},
    {P3964R_DLE, "DLE"},
    {P3964R_NAK, "NAK"},
    {0, NULL},
};

const value_string sis_procedure_verdicts[] = {
    {0, "OK"},
    {1, "Exceeded"},
    {2, "Unresolved"},
    {0, NULL},
};

const value_string sis_arcnet7f_commands[] = {
    {ARCNET7F_TO, "TO"},
    {ARCNET7F_FETCH, "FETCH"},
    {0, NULL},
};

const value_string sis_arcnet7f_types[] = {
    {ARCNET7F_WORD_ARRAY, "Word array"},
    {0, NULL},
};

const value_string sis_rk512_commands[] = {
    {RK512_SEND, "SEND"},
    {RK512_FETCH, "FETCH"},
    {0x4F, "SEND to an extended data block"},
    {0, NULL},
};

const value_string sis_rk512_kinds[] = {
    {0x44, "Data block"},
    {0x58, "Extended data block"},
    {0x45, "Inputs"},
    {0x41, "Outputs"},
    {0x4D, "Flags"},
    {0x54, "Timers"},
    {0x5A, "Counters"},
    {0, NULL},
};

const value_string sis_rk512_errors[] = {
    {0x00, "No error"},
    {0x0A, "Access to the area not possible"},
    {0x0C, "Wrong data type"},
    {0x10, "Telegram not supported"},
    {0x12, "Object type not supported"},
    {0x14, "Block not found, or its number not allowed"},
    {0x16, "Unknown command"},
    {0x2A, "PLC stopped"},
    {0x32, "Block locked by its coordination flag"},
    {0x34, "Wrong length"},
    {0x36, "Follow-up without a command"},
    {0, NULL},
};

const value_string sis_rk512_telegrams[] = {
    {0x00, "First telegram"},
    {0xFF, "Follow-up"},
    {0, NULL},
};

const value_string sis_synaxobj_operations[] = {
    {SYNAXOBJ_READ_ANSWER, "read answer"},
    {SYNAXOBJ_WRITE_REQUEST, "write request"},
    {SYNAXOBJ_READ_REQUEST, "read request"},
    {SYNAXOBJ_WRITE_ANSWER, "write answer"},
    {0, NULL},
};

const value_string sis_synaxobj_names[] = {
    {0x5E70, "Data exchange, 16 bytes"},
    {0x5E71, "Data exchange, 32 bytes"},
    {0x5E72, "Data exchange, 64 bytes"},
    {0x5E73, "Data exchange, 128 bytes"},
    {SYNAXOBJ_DIAGNOSIS_FIELDBUS, "Diagnosis fieldbus"},
    {SYNAXOBJ_STATUS_FIELDBUS, "Status fieldbus"},
    {0x5FF5, "Written by the PPC, name not known"},
    {SYNAXOBJ_FAULT_CODE_PPC, "Fault code PPC"},
    {0x5FFC, "Control of the multiplex channel"},
    {0x5FFD, "Control of the multiplex channel"},
    {0x5FFE, "Control of the multiplex channel"},
    {0, NULL},
};

const value_string sis_synaxpcp_services[] = {
    {0x0081, "Read request"},
    {0x0082, "Write request"},
    {0x0086, "Status request"},
    {0x0087, "Identify request"},
    {0x0088, "Get OV request"},
    {0x008B, "Initiate request"},
    {0x008D, "Abort request"},
    {0x00A1, "Read response"},
    {0x00A2, "Write response"},
    {0x00AB, "Initiate response"},
    {0x00AC, "Initiate error response"},
    {0x0181, "Read confirmation"},
    {0x0182, "Write confirmation"},
    {0x0186, "Status confirmation"},
    {0x0187, "Identify confirmation"},
    {0x0188, "Get OV confirmation"},
    {0x018B, "Initiate confirmation"},
    {0x018C, "Initiate error confirmation"},
    {0x01A1, "Read indication"},
    {0x01A2, "Write indication"},
    {0x01AB, "Initiate indication"},
    {0x01AD, "Abort indication"},
    {0, NULL},
};

const value_string sis_synaxpcp_errors[] = {
    {0x06030000, "no access"},
    {0x06050011, "invalid subindex"},
    {0x06050012, "data too long"},
    {0x06050013, "data too short"},
    {0x06060000, "the object is not a parameter"},
    {0x06070000, "the object does not exist"},
    {0x08000000, "the service cannot be executed"},
    {0x08000020, "the service cannot be executed now"},
    {0, NULL},
};

const value_string sis_synaxpd_directions[] = {
    {SYNAXPD_TO_PPC, "to the PPC"},
    {SYNAXPD_FROM_PPC, "from the PPC"},
    {0, NULL},
};

const value_string sis_channel_formats[] = {
    {SYNAXPK_DRIVE_SHORT_1, "S/P parameter, short format 1"},
    {SYNAXPK_A_SHORT_1, "A parameter, short format 1"},
    {SYNAXPK_SIS_FORMAT, "Indramat SIS"},
    {0x0F, "Basic state"},
    {0, NULL},
};

const value_string sis_channel_senders[] = {
    {SYNAXPK_MASTER, "Master"},
    {SYNAXPK_SLAVE, "Slave"},
    {0, NULL},
};

const range_string sis_channel_codes[] = {
    {0x0085, 0x0085, "Sum of the fragments too large"},
    {0x0088, 0x0088, "Internal error between card and drive"},
    {0x008A, 0x008A, "Index not present"},
    {0x008B, 0x008B, "Format unknown"},
    {0x008C, 0x008C, "Length longer than the channel"},
    {0x008D, 0x008D, "The channel has only one word"},
    {0x0090, 0x0090, "Format changed between fragments"},
    {0x0095, 0x0095, "Read request with more than index and subindex"},
    {0x0096, 0x0096, "Internal SIS communication error"},
    {0x009A, 0x009A, "Not implemented"},
    {0x009B, 0x009B, "Change between old and new channel"},
    {0x009C, 0x009C, "Subindex does not exist"},
    {0x009D, 0x009D, "Subindex write-protected"},
    {0x00F0, 0x00F0, "Timeout between card and drive"},
    {0x01FF, 0x01FF, "Length wrong: more than 128 bytes"},
    {0x1F00, 0x1FFF, "Error of the application SYNAX"},
    {0, 0, NULL},
};

const value_string sis_ascii_kinds[] = {
    {SISASCII_TEXT, "Text"},
    {SISASCII_OPEN, "Open drive"},
    {SISASCII_PROMPT, "Prompt of drive"},
    {SISASCII_READ, "Read parameter"},
    {SISASCII_WRITE, "Write parameter"},
    {SISASCII_ELEMENT, "List element"},
    {SISASCII_ASKS, "Asks for a list element"},
    {SISASCII_ERROR, "Error"},
    {SISASCII_ECHO, "Echo"},
    {SISASCII_ANSWER, "Answer"},
    {SISASCII_END, "End of list"},
    {0, NULL},
};

const value_string sis_errors_ascii[] = {
    {0x9001, "Characters not recognized"},
    {0x9002, "Wrong type of parameter"},
    {0x9003, "Wrong number of the parameter set"},
    {0x9004, "Input not recognized"},
    {0x9005, "Element not defined"},
    {0x9006, "Neither r nor w"},
    {0x9007, "Wrong character in the data"},
    {0, NULL},
};

const value_string sis_parameters_a[] = {
    {4, "Additive position command value, target value"},
    {56, "Set-up position 0"},
    {60, "Fine adjustment"},
    {0, NULL},
};

const value_string sis_parameters_c[] = {
    {1, "Switch-on delay time"},
    {29, "Jogging time constant"},
    {33, "Host communication, control word"},
    {46, "General diagnostic flag"},
    {57, "Error number of the serial interface"},
    {58, "Configuration list of data block 101"},
    {59, "Configuration list of data block 102"},
    {60, "Configuration list of data block 103"},
    {61, "Configuration list of data block 104"},
    {62, "Configuration list of data block 105"},
    {63, "Configuration list of data block 106"},
    {64, "Configuration list of data block 107"},
    {65, "Configuration list of data block 108"},
    {66, "Master axis, position feedback value"},
    {124, "Timeout of the service channel"},
    {125, "Fieldbus address"},
    {127, "Fieldbus/Ethernet 1, configuration list of the process input data"},
    {129, "Fieldbus control bits"},
    {157, "Data blocks, ident numbers of the configurable S and P parameters"},
    {188, "Ethernet 2, configuration list"},
    {193, "PPC, standard gateway"},
    {194, "PPC, UDP ports"},
    {197, "End of the static part of a configuration list"},
    {198, "End of a multiplex level of a configuration list"},
    {0, NULL},
};

const range_string sis_synax_blocks[] = {
    {98, 98, "cancel a transmission with follow-ups"},
    {SYNAX_BLOCK_IO, SYNAX_BLOCK_IO, "inputs and outputs of the PPC"},
    {SYNAX_BLOCK_MODE, SYNAX_BLOCK_MODE, "mode of the PPC"},
    {101, 116, "freely configured"},
    {0, 0, NULL},
};
