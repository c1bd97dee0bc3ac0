-- What Wireshark's Lua gives, and luacheck does not know.
std = "lua52"
max_line_length = 120
read_globals = {
  "base", "bit", "ByteArray", "DESEGMENT_ONE_MORE_SEGMENT", "Dir", "dissect_tcp_pdus", "Dissector", "DissectorTable",
  "ENC_UTF_8", "expert", "Field", "frametype", "ftypes", "get_version", "gui_enabled", "Listener", "MENU_STAT_UNSORTED",
  "NSTime", "Pref", "Proto", "ProtoExpert", "ProtoField", "register_menu", "retap_packets", "Struct", "TextWindow", "TreeItem", "Tvb", "TvbRange",
  "UInt64", "wtap",
}
