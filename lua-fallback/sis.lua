-- SPDX-License-Identifier: GPL-2.0-or-later
-- The SIS telegram and the serial tap's record in Lua: one file for Wireshark 4.0 and later, no compiler. Put it into
-- the personal plugin folder (Help > About Wireshark > Folders).
--
-- It shows what the C plugin in plugin/ shows, and is written like it: a block a file, with the same names; each begins
-- with a line "--- name:". Where a block says nothing, the comments of its C file hold. README.md lists what Lua cannot
-- do.

--- head: guards, aliases, and what all blocks use

if tonumber(string.match(get_version(), "^%d+")) < 4 then
  error("sis.lua needs Wireshark 4.0 or later, this is " .. get_version(), 0)
end

-- The C plugin is loaded first, or another copy of this file: it has everything that this file has.
for _, name in ipairs(Dissector.list()) do
  if name == "sis" or name == "sertap" then
    io.stderr:write("sis.lua: " .. name .. " is there already, so this copy does nothing\n")
    return
  end
end

local floor, fmod, max, min = math.floor, math.fmod, math.max, math.min
local byte, char, rep, sub, strformat = string.byte, string.char, string.rep, string.sub, string.format
local match, gsub = string.match, string.gsub
local concat, unpack = table.concat, table.unpack
local band, bxor, lshift, rshift = bit.band, bit.bxor, bit.lshift, bit.rshift -- signed: up to 31 bits only
-- Methods that every telegram needs: Wireshark takes as long to find one as to call it.
local raw, reported_len, tvb_of = Tvb.raw, Tvb.reported_len, TvbRange.tvb
local item_add, item_add_le, is_referenced = TreeItem.add, TreeItem.add_le, TreeItem.referenced
local item_set_generated, item_set_hidden, new_time = TreeItem.set_generated, TreeItem.set_hidden, NSTime.new

--- protocols: made by plugin/protocol/generate.py from protocols.toml; edit there

local sertap = Proto("sertap", "Serial tap")
local sis = Proto("sis", "Rexroth SIS serial protocol")
sis.prefs.edition = Pref.enum("Edition of the telegram header", 0,
  "Address ranges, and bits 5 to 7 of the telegram control, differ between editions",
  {{"IF02", "IF02 (SIS definition of 2004, IndraDrive)", 0}, {"ECODRIVE03", "ECODRIVE03 (FGP-01VRS)", 1}}, false)
sis.prefs.clc_as_sercos = Pref.bool("Decode services 0xC0 to 0xCF like 0x10 to 0x1F", false,
  "The CLC's services are said to be close to the SERCOS services; their layout is not documented")
sis.prefs.ecodrive_phases = Pref.bool("Decode services 0x82 and 0x8D like 0x12 and 0x1D", false,
  "Reading and switching the phase of an ECODRIVE this way is not confirmed")
sis.prefs.tza_ms = Pref.uint("TzA in ms", 0,
  "Longest interval allowed between two characters of a telegram; 0: as the bus was told")
sis.prefs.tza_from = Pref.enum("TzA counts from", 0,
  "No document says whether the character that ends an interval counts. Unknown: where that decides, "
    .. "a verdict is unresolved", {{"unknown", "Unknown", 0},
  {"end", "The end of the character before: the pause alone", 1},
  {"start", "The start of the character before: the whole interval", 2}}, false)
sis.prefs.trs_ms = Pref.uint("TrS in ms", 0, "Longest reaction time allowed; 0: as the bus was told")
sis.prefs.tcp_heuristic = Pref.bool("Recognize SIS on any TCP port", true,
  "Where a segment starts with a whole telegram: equal lengths, right checksum; or with a command of "
    .. "the ASCII protocol")
sis.prefs.udp_heuristic = Pref.bool("Recognize SIS on any UDP port", false,
  "The same for a datagram. Process data of a PPC may look like a telegram by chance")
local p3964r = Proto("3964r", "3964R procedure")
p3964r.prefs.zvz_ms = Pref.uint("ZVZ in ms", 220, "Longest interval between two characters of a block; 0: no verdict")
p3964r.prefs.qvz_ms = Pref.uint("QVZ in ms", 2000, "Longest time to the partner's answer; 0: no verdict")
local rk512i = Proto("rk512i", "RK512 with the Indramat extension")
local arcnet7f = Proto("arcnet7f", "Rexroth SYNAX200 on ARCNET")
local synax = Proto("synax", "Rexroth SYNAX200 transports")
local synaxpk = Proto("synaxpk", "Rexroth SYNAX200 parameter channel")
synaxpk.prefs.layout = Pref.enum("Layout of the control and status word", 0,
  "IndraDrive has a parameter channel of its own", {{"synax", "SYNAX200", 0}, {"indradrive", "IndraDrive", 1}}, false)
synaxpk.prefs.direction = Pref.enum("Sender", 0,
  "Who has sent the packets: in a capture made at the master, what it sent comes from the master, and "
    .. "what it received from the slave", {{"guess", "As the packet says: sent, received", 0}, {"master", "Master", 1},
  {"slave", "Slave", 2}}, false)
local synaxobj = Proto("synaxobj", "Rexroth SYNAX200 object")
local synaxpcp = Proto("synaxpcp", "Interbus PCP")
local synaxpd = Proto("synaxpd", "Rexroth SYNAX200 process data")
synaxpd.prefs.ports = Pref.range("UDP ports of the PPC", "", "Those of parameter C-0-0194; none is known by itself",
  65535)
synaxpd.prefs.swap_bytes = Pref.bool("Bytes of a word are swapped", false, "As bits of C-0-0129 say")
synaxpd.prefs.swap_words = Pref.bool("Words of a double word are swapped", false, "As bits of C-0-0129 say")
local sisascii = Proto("sisascii", "Rexroth ASCII protocol")

local protos = {["sertap"] = sertap, ["sis"] = sis, ["3964r"] = p3964r, ["rk512i"] = rk512i, ["arcnet7f"] = arcnet7f,
  ["synax"] = synax, ["synaxpk"] = synaxpk, ["synaxobj"] = synaxobj, ["synaxpcp"] = synaxpcp, ["synaxpd"] = synaxpd,
  ["sisascii"] = sisascii} -- by filter name

local P = {edition = 0, clc_as_sercos = false, ecodrive_phases = false, tza_ms = 0, tza_from = 0, trs_ms = 0,
  tcp_heuristic = true, udp_heuristic = false} -- values of the preferences of sis
-- end of protocols

-- Functions shared by blocks, with their names in the C headers: S.take for sis_take(), T.load for sertap_load().
local S, T = {}, {}
-- Fields and expert items of sis, and of sertap: F.service for hf_sis_service, E.body_missing for
-- ei_sis_body_missing. Those of other protocols have their whole names: FX.rk512i_command.
local F, FT, FX, E, ET, EX = {}, {}, {}, {}, {}, {}
-- Constants; texts of codes.
local K, N = {}, {}

K.PORT_TYPE_TCP = 2 -- of pinfo.port_type; 0: the packet has no ports

local label, kind_of, base_of = {}, {}, {} -- of a field
local name_of = {} -- of a field or an expert item, for filters

local registered = {} -- by protocol: {fields, experts}

-- Registers the fields and experts of a protocol; `of_sis`, `of_sertap` and `others` hold them.
local function declare(abbreviation, kind, made, of_sis, of_sertap, others)
  local owner, name = match(abbreviation, "^(%w+)%.(.*)$")

  name_of[made] = abbreviation
  registered[owner] = registered[owner] or {fields = {}, experts = {}}
  table.insert(registered[owner][kind], made)
  if owner == "sis" then
    of_sis[gsub(name, "%.", "_")] = made
  elseif owner == "sertap" then
    of_sertap[gsub(name, "%.", "_")] = made
  else
    others[gsub(abbreviation, "%.", "_")] = made
  end
end

-- Declares a field.
local function field(abbreviation, text, kind, display, strings, mask, description)
  local made = ProtoField.new(text, abbreviation, kind, strings, display, mask, description)

  label[made], kind_of[made], base_of[made] = text, kind, display
  declare(abbreviation, "fields", made, F, FT, FX)
end

-- Declares an expert item; group and severity as Wireshark's Lua names them.
local function expert_field(abbreviation, group, severity, text)
  local made = ProtoExpert.new(abbreviation, text, expert.group[group], expert.severity[severity])

  declare(abbreviation, "experts", made, E, ET, EX)
end

sis.prefs.fields = Pref.string("Fields to make", "",
  "Those of sis and sertap that a program reads, with commas between them, so that it need not wait for the others; "
    .. "empty: all")
P.fields = ""

-- Fields of sis and sertap that nobody reads, and protocols whose words nobody reads; whether somebody reads a field of
-- a part of a telegram; whether a person may read the texts of items.
local unwanted, has_wanted, are_texts_read = {}, {}, true

-- The part by the first word of a field. All others are in the useful data; sis.service may be there, too (chapter 7).
local part_of = {}

for word in string.gmatch("start checksum length length_repeat control service sender receiver subaddress number "
  .. "talker listener station stream reaction_in command_in reaction_time repeat_of unanswered_before next_command_in "
  .. "answered_in routed_from", "%S+") do
  part_of[word] = "head"
end
for word in string.gmatch("silence_before tza trs twm tmas bus", "%S+") do
  part_of[word] = "timing"
end

-- A protocol stands for all of its fields.
local function find_wanted()
  local named = {}

  for name in string.gmatch(P.fields, "[^%s,]+") do
    named[name] = true
  end
  local is_all = next(named) == nil

  unwanted, has_wanted = {}, {head = is_all, data = is_all, timing = is_all}
  for _, owner in ipairs({"sertap", "sis"}) do
    unwanted[protos[owner]] = not is_all and not named[owner]
    for _, which in ipairs(registered[owner].fields) do
      local name = name_of[which]
      local word = match(name, "^sis%.([%w_]+)")

      if not is_all and not named[owner] and not named[name] then
        unwanted[which] = which ~= FT.text -- Wireshark says what is wrong in a text
      elseif word then
        has_wanted[part_of[word] or "data"] = true
      end
    end
  end
  are_texts_read = not unwanted[sis] or not unwanted[sertap]
end

local function read_preferences()
  for name in pairs(P) do
    P[name] = sis.prefs[name]
  end
  find_wanted()
end

sis.prefs_changed = read_preferences

-- Data of a file, deleted when the next one is opened.
local init_routines = {}

local function at_init(routine)
  init_routines[#init_routines + 1] = routine
end

function sis.init()
  read_preferences() -- a change of profile resets the preferences without a call
  for _, routine in ipairs(init_routines) do
    routine()
  end
end

-- The data about telegrams grow, and each garbage collection scans all of them. So it waits until Lua's memory is 4
-- times what was in use, not 2 times. This applies to all scripts.
collectgarbage("setpause", 400)

-- A cache: returns a function that makes something of a string, or remembers it. A full cache is cleared. So it is
-- for the next file, which may have other preferences.
local function remembered(most, make)
  local known, count

  local function forget()
    known, count = {}, 0
  end

  at_init(forget)
  forget()
  return function(text)
    local made = known[text]

    if not made then
      if count == most then forget() end
      made = make(text)
      known[text] = made
      count = count + 1
    end
    return made
  end
end

local CHUNK = 64 -- number of values in one call: all of them are on Lua's stack

-- Sum of values, without a table of them.
local function total(sum, a, b, c, d, e, f, g, h, ...)
  if not h then return sum + (a or 0) + (b or 0) + (c or 0) + (d or 0) + (e or 0) + (f or 0) + (g or 0) end
  return total(sum + a + b + c + d + e + f + g + h, ...)
end

-- Items of the tree. Without a tree, without an item, or for a field that nobody wants they do nothing.

-- Whether somebody wants the field in this tree.
local function is_wanted(tree, which)
  return tree and not unwanted[which] and is_referenced(tree, which)
end

local counts -- how often each field was added, while somebody wants to know; else nil: sis/packed

local function count_field(which)
  counts[which] = (counts[which] or 0) + 1
end

-- A field with its value, or with the value of its bytes, big endian; `text` replaces the displayed text.
local function add(tree, which, tvb, offset, length, value, text)
  if tree == nil or unwanted[which] then return nil end
  if counts then count_field(which) end
  if text ~= nil then
    return item_add(tree, which, tvb(offset, length), value, text)
  elseif value ~= nil then
    return item_add(tree, which, tvb(offset, length), value)
  end
  return item_add(tree, which, tvb(offset, length))
end

-- The same with little-endian bytes.
local function add_le(tree, which, tvb, offset, length)
  if tree == nil or unwanted[which] then return nil end
  if counts then count_field(which) end
  return item_add_le(tree, which, tvb(offset, length))
end

-- A text of a format with its values, or of a function with its arguments.
local function text_of(make, ...)
  if type(make) == "function" then return make(...) end
  return strformat(make, ...)
end

-- A field with its value, and after its name a text_of(...).
local function add_value(tree, which, tvb, offset, length, value, ...)
  if tree == nil or unwanted[which] then return nil end
  if not are_texts_read then return add(tree, which, tvb, offset, length, value) end
  return add(tree, which, tvb, offset, length, value, label[which] .. ": " .. text_of(...))
end

-- The bytes up to `stop`, if there are any.
local function add_bytes(tree, which, tvb, offset, stop)
  if stop > offset then add(tree, which, tvb, offset, stop - offset) end
end

-- A text line without a field, to have items below it.
local function add_subtree(tree, tvb, offset, length, text)
  if tree and are_texts_read then return item_add(tree, tvb(offset, length), text) end
  return tree
end

local function append_text(item, text)
  if item then item:append_text(text) end
end

local function set_generated(item)
  return item and item_set_generated(item)
end

local function set_hidden(item)
  return item and item_set_hidden(item)
end

-- A number that stands for no bytes: what was found out about a packet. Without a value, nothing.
local function add_generated(tree, which, tvb, value)
  return value and set_generated(add(tree, which, tvb, 0, 0, value))
end

-- Counts side effects of dissecting: expert items, and data kept for later telegrams. A telegram without side effects
-- need not be dissected again for the same bytes.
local effects = 0

-- An expert item; by default with its declared text.
local function add_expert(item, which, text)
  effects = effects + 1
  if counts then count_field(which) end
  if text then item:add_proto_expert_info(which, text) else item:add_proto_expert_info(which) end
end

-- Converts ns to Wireshark's time.
local function nstime(ns)
  local rest = fmod(ns, 1e9)

  return new_time((ns - rest) / 1e9, rest)
end

-- A duration in ns, with a text as add_value() takes it.
local function add_duration(tree, which, tvb, offset, length, ns, ...)
  if tree == nil or unwanted[which] then return nil end
  return add_value(tree, which, tvb, offset, length, nstime(ns), ...)
end

local function plural(count)
  return count == 1 and "" or "s"
end

-- Wireshark's message for a packet that the capture has cut. Lua cannot raise its exception.
function S.show_cut(tvb, pinfo, parent, name)
  parent:add(tvb(0, 0), "[Packet size limited during capture: " .. name .. " truncated]")
  pinfo.cols.info:append("[Packet size limited during capture]")
end

-- "02 5e".
local function hex(bytes)
  local spaced = string.gsub(bytes, ".", function(c) return strformat("%02x ", byte(c)) end)

  return sub(spaced, 1, -2)
end

-- The text of a value in ranges {first, last, text}: the first that fits; nil if none does.
local function range_text(value, ranges)
  for _, range in ipairs(ranges) do
    if value >= range[1] and value <= range[2] then
      return range[3], range
    end
  end
end

-- Times of packets, by number: ns since the first packet. Lua has the time since 1970 as a double of seconds, too
-- coarse for ns. The time since the first packet is exact for weeks. A time reference of the user changes it, so the
-- value of the first pass is kept.
local packet_times

at_init(function() packet_times = {} end)

local function packet_time(pinfo, number)
  local time = packet_times[number]

  if not time then
    time = T.elapsed(0, floor(pinfo.rel_ts * 1e9 + 0.5))
    packet_times[number] = time
  end
  return time
end

-- The packet being dissected. Asking Wireshark takes time, so each value is requested once.
local packet = {
  number = nil,
  visited = nil, -- whether this is a later pass
  time = nil, -- ns
  port_type = nil,
  record = nil, -- of the serial tap, while its payload is dissected
  cols = nil,
  count = 0, -- telegrams whose exchange was looked for; this count is the key of data kept for a packet
  telegrams = 0, -- dissected so far, and what stands in the place of one
}

local function look_at(pinfo)
  local number = pinfo.number

  packet.number = number
  packet.visited = pinfo.visited
  packet.time = packet_time(pinfo, number)
  packet.port_type = pinfo.port_type
  packet.record = nil
end

-- The section of a packet in the capture, from 0, and its interface; 0 without one, and in the first of two passes of
-- tshark, which gives Lua no fields unless a filter needs some.
local frame_section_number, frame_interface_id = Field.new("frame.section_number"), Field.new("frame.interface_id")
local place_of, section, interface -- of the last requested packet: every field takes time

at_init(function() place_of = nil end)

function S.place()
  local number = packet.number

  if number ~= place_of then
    local found_section, found_interface = frame_section_number(), frame_interface_id()

    place_of = number
    section = found_section and found_section.value - 1 or 0
    interface = found_interface and found_interface.value or 0
  end
  return section, interface
end

-- A line of the capture as a number: every section has its own numbers of interfaces.
function S.line_key(of_section, of_interface)
  return of_section * 0x100000000 + of_interface
end

-- The line, or both directions of a full-duplex tap, which are two successive interfaces.
function T.bus_key()
  local record, of_section, of_interface = packet.record, S.place()

  return S.line_key(of_section, record and record.line == 2 and max(of_interface - 1, 0) or of_interface)
end

-- The TCP connection of a packet: its two ends, as text. Its number is a field, and the first pass of tshark has
-- none.
function S.connection(pinfo)
  local one = tostring(pinfo.net_src) .. " " .. pinfo.src_port
  local other = tostring(pinfo.net_dst) .. " " .. pinfo.dst_port

  return one < other and one .. " " .. other or other .. " " .. one
end

-- Each block stands in do ... end: Lua allows 200 locals at a time.

--- codes: made by plugin/protocol/generate.py from codes.toml; edit there

-- Fig. 2-9 and chapters 3 to 9. The first entry that fits names a service: single ones before their ranges.
N.services = {
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
}

-- Kinds of addresses, fig. 2-9; the editions assign them to different addresses (address.c).
K.STATION = 0
K.SERVICE_MASTER = 1
K.POINT_TO_POINT = 2
K.NOT_ASSIGNED = 3
K.RESERVED = 4
K.NO_SENDER = 5
K.GROUP = 6
K.LEVEL_BROADCAST = 7
K.GLOBAL_BROADCAST = 8
N.address_kinds = {
  [K.STATION] = "station",
  [K.SERVICE_MASTER] = "service or emergency master",
  [K.POINT_TO_POINT] = "point-to-point",
  [K.NOT_ASSIGNED] = "not assigned",
  [K.RESERVED] = "reserved",
  [K.NO_SENDER] = "not a sender address",
  [K.GROUP] = "logical group",
  [K.LEVEL_BROADCAST] = "broadcast on one hierarchy level",
  [K.GLOBAL_BROADCAST] = "global broadcast",
}

-- What a command of a service is, fig. 2-3: SEND writes, FETCH reads. Of 0x02 its subservice decides, of a list (0x04)
-- its elements.
N.command_kinds = {
  [0x00] = "FETCH",
  [0x03] = "SEND",
  [0x10] = "FETCH",
  [0x11] = "FETCH",
  [0x12] = "FETCH",
  [0x1D] = "SEND",
  [0x1E] = "SEND",
  [0x1F] = "SEND",
}

-- What a command to several stations is, by the kind of its address, fig. 2-3. Nobody answers it.
N.message_kinds = {
  [6] = "group message, no reaction",
  [7] = "broadcast message, no reaction",
  [8] = "broadcast message, no reaction",
}

-- Telegram control bits 7, 6, 5 of a reaction, ECODRIVE03; the order of the bits is inferred.
N.control_status_ecodrive03 = {
  [0] = "No error, request processed",
  [1] = "Request still being processed",
  [2] = "Request cannot be processed now",
  [3] = "Not defined",
  [4] = "Warning",
  [5] = "Not defined",
  [6] = "Error",
  [7] = "Not defined",
}

-- Status byte of a reaction, fig. 2-18; 0xF9 to 0xFC from the IndraDrive manual.
N.status = {
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
}

-- The same byte in reactions of phase services (chapters 8.4 and 8.5): 2 has another meaning there, and 1 has none.
N.status_phase = {
  [0x01] = "Execution error, not specified for this service",
  [0x02] = "Phase switching error",
}

-- The error code after status 2, unless a service has another meaning for it, fig. 2-19.
N.errors_channel = {
  [0x8001] = "Transmission channel busy",
  [0x8002] = "Fault in the transmission channel",
  [0x800B] = "Transmission cancelled, another request had priority",
  [0x800C] = "Access not allowed, the transmission channel is still active",
}

-- What to do after a code of the channel, fig. 2-19.
N.advice_channel = {
  [0x8001] = "repeat the command until the channel is free",
  [0x8002] = "repeat the command to see whether the fault lasts",
  [0x800B] = "repeat the command until it is executed without being cancelled",
  [0x800C] = "repeat the command until the active request has ended",
}

-- Subservices of 0x00, chapter 3.
N.subservices_identification = {
  [0x01] = "SIS version",
  [0x02] = "Firmware (FWA) number",
  [0x03] = "Device type key",
  [0x04] = "Supported baud rates",
}

-- Subservices of 0x02, chapter 5.
N.subservices_flash = {
  [0x90] = "Shutdown",
  [0x91] = "Reboot",
  [0x92] = "Read flash",
  [0x93] = "Find header",
  [0x94] = "Erase flash",
  [0x96] = "Program flash",
  [0x97] = "Build checksum",
  [0x9F] = "Reset errors in the slave",
}

-- Subservice and error byte of 0x02, chapter 5.3; those with 0x10 and 0x0B from the IndraDrive manual.
N.errors_flash = {
  [0x9002] = "Firmware was deleted",
  [0x9003] = "Shutdown not allowed in phase 3",
  [0x9004] = "Shutdown not allowed in phase 4",
  [0x9010] = "Shutdown not allowed in operating mode",
  [0x9102] = "Firmware was deleted",
  [0x9103] = "Reboot not allowed in phase 3",
  [0x9104] = "Reboot not allowed in phase 4",
  [0x9110] = "Reboot not allowed in operating mode",
  [0x9200] = "Read error",
  [0x920B] = "More than the maximum of useful data",
  [0x9400] = "Timeout while erasing",
  [0x940A] = "Erasing is only possible in the loader",
  [0x96E0] = "Verify error while programming the flash",
  [0x96E1] = "Timeout while programming the flash",
  [0x96FF] = "Error while writing to the RAM",
  [0x9701] = "Additive checksum wrong",
  [0x9702] = "CRC32 checksum wrong",
}

-- Destination of Shutdown, chapter 5.1.
N.shutdown_targets = {
  [0x00] = "Firmware",
  [0x01] = "Loader",
}

-- Device types of Program flash, chapter 5.1.
N.device_types = {
  [0x00] = "None (not supported)",
  [0x01] = "ROM (not supported)",
  [0x02] = "RAM",
  [0x03] = "Dual-port RAM",
  [0x04] = "Flash",
}

-- Subservices of 0x03, chapter 6.
K.SET_TRS = 0x01
K.SET_TZA = 0x02
K.SET_TMAS = 0x03
K.SET_BAUD_RATE = 0x07
K.TEST_BAUD = 0x08
K.ACCEPT = 0xFF
N.subservices_initialization = {
  [K.SET_TRS] = "Set TrS (slave reaction time)",
  [K.SET_TZA] = "Set TzA (character interval)",
  [K.SET_TMAS] = "Set Tmas (master control word cycle)",
  [0x06] = "Assign multicast group",
  [K.SET_BAUD_RATE] = "Set baud rate",
  [K.TEST_BAUD] = "Timed baud rate test",
  [K.ACCEPT] = "Accept the set values",
}

-- Subservice and error byte of 0x03, chapter 6.3.
N.errors_initialization = {
  [0x0700] = "Baud rate not supported",
  [0x0800] = "Baud rate not supported",
  [0x0801] = "Test time too large for the internal timer",
}

-- Baud rate mask, fig. 3-10, 6-11 and 6-17.
N.baud_masks = {
  [0x00] = "9600",
  [0x01] = "19200",
  [0x02] = "38400",
  [0x04] = "57600",
  [0x08] = "115200",
}

-- Elements of a parameter, bits 3 to 5 of the parameter control, fig. 8-1.
N.elements = {
  [0] = "Channel not active",
  [1] = "Ident number",
  [2] = "Name",
  [3] = "Attribute",
  [4] = "Unit",
  [5] = "Minimum",
  [6] = "Maximum",
  [7] = "Operating data",
}

-- Error codes of parameter services, fig. 8-48; 0x00A0 and 0x00B0 from SYNAX, 0x8002, 0x800B and 0x800C from
-- IndraDrive, whose manual has two meanings for the last.
N.errors_parameter = {
  [0x0000] = "No error",
  [0x0001] = "Service channel not open",
  [0x0009] = "Wrong access to element 0",
  [0x00A0] = "Request not allowed",
  [0x00B0] = "Element not allowed",
  [0x1001] = "Ident number not available",
  [0x1009] = "Wrong access to element 1",
  [0x2001] = "Name not available",
  [0x2002] = "Name transmitted too short",
  [0x2003] = "Name transmitted too long",
  [0x2004] = "Name cannot be changed",
  [0x2005] = "Name is write-protected at present",
  [0x3002] = "Attribute transmitted too short",
  [0x3003] = "Attribute transmitted too long",
  [0x3004] = "Attribute cannot be changed",
  [0x3005] = "Attribute is write-protected at present",
  [0x4001] = "Unit not available",
  [0x4002] = "Unit transmitted too short",
  [0x4003] = "Unit transmitted too long",
  [0x4004] = "Unit cannot be changed",
  [0x4005] = "Unit is write-protected at present",
  [0x5001] = "Minimum not available",
  [0x5002] = "Minimum transmitted too short",
  [0x5003] = "Minimum transmitted too long",
  [0x5004] = "Minimum cannot be changed",
  [0x5005] = "Minimum is write-protected at present",
  [0x6001] = "Maximum not available",
  [0x6002] = "Maximum transmitted too short",
  [0x6003] = "Maximum transmitted too long",
  [0x6004] = "Maximum cannot be changed",
  [0x6005] = "Maximum is write-protected at present",
  [0x7002] = "Operating data transmitted too short",
  [0x7003] = "Operating data transmitted too long",
  [0x7004] = "Operating data cannot be changed",
  [0x7005] = "Operating data are write-protected at present",
  [0x7006] = "Operating data smaller than the minimum",
  [0x7007] = "Operating data greater than the maximum",
  [0x7008] = "Operating data not correct",
  [0x700C] = "Operating data outside the range: below zero, or above the modulo value of a modulo axis",
  [0x700D] = "The length of the operating data cannot be changed at present",
  [0x700E] = "The length of the operating data cannot be changed",
  [0x700F] = "List element not available, or the list offset is not the start of an element",
  [0x8001] = "Service channel busy",
  [0x8002] = "Failure in the service channel",
  [0x800B] = "Transmission cancelled, another request had priority",
  [0x800C] = "Service channel still active, or parameter occupied by a sequential transmission",
}

-- What else is said of an error code of parameter services, fig. 8-48.
N.advice_parameter = {
  [0x8001] = "not done within the time-out, which C-0-0124 sets; nothing was transferred",
}

-- Error codes of a phase switch, fig. 8-49.
N.errors_phase = {
  [0x8004] = "Wrong phase requested over the serial protocol",
  [0xD005] = "Phase switch still active",
  [0xD006] = "Phase switch not allowed while a drive is enabled",
  [0xD007] = "Phase switch not allowed while the master axis turns",
}

-- Phases with a mode, chapter 8.5.
N.phases = {
  [2] = "parameter mode",
  [4] = "operating mode",
}

-- Data status of a command, bits 0 to 3, fig. 8-44.
N.data_states = {
  [0x00] = "not set",
  [0x03] = "done",
  [0x05] = "interrupted",
  [0x07] = "in process",
  [0x0F] = "execution not possible",
}

-- Types of a parameter, fig. 8-3.
N.parameter_types = {
  [0] = "Parameter of a drive",
  [1] = "Control parameter, first kind (A)",
  [2] = "Control parameter, second kind (C)",
}

-- Length of a value, bits 16 to 18 of the attribute (IEC 61491).
N.attribute_lengths = {
  [0] = "Not defined",
  [1] = "2 bytes",
  [2] = "4 bytes",
  [3] = "8 bytes",
  [4] = "List of single bytes",
  [5] = "List of 2-byte elements",
  [6] = "List of 4-byte elements",
  [7] = "List of 8-byte elements",
}

-- Format of a value, bits 20 to 22 of the attribute (IEC 61491).
K.FORMAT_BINARY = 0
K.FORMAT_UNSIGNED = 1
K.FORMAT_SIGNED = 2
K.FORMAT_HEXADECIMAL = 3
K.FORMAT_TEXT = 4
K.FORMAT_IDENT = 5
K.FORMAT_FLOATING = 6
K.FORMAT_TIME = 7
N.attribute_formats = {
  [K.FORMAT_BINARY] = "Binary",
  [K.FORMAT_UNSIGNED] = "Unsigned decimal",
  [K.FORMAT_SIGNED] = "Signed decimal",
  [K.FORMAT_HEXADECIMAL] = "Hexadecimal",
  [K.FORMAT_TEXT] = "Text",
  [K.FORMAT_IDENT] = "Ident number",
  [K.FORMAT_FLOATING] = "Floating point",
  [K.FORMAT_TIME] = "Time",
}

-- Types of a record of the tap.
K.SERTAP_FRAME = 0
K.SERTAP_OTHER = 1
K.SERTAP_EVENT = 2
K.SERTAP_BEFORE = 3
N.sertap_types = {
  [K.SERTAP_FRAME] = "Frame",
  [K.SERTAP_OTHER] = "Other characters",
  [K.SERTAP_EVENT] = "Event",
  [K.SERTAP_BEFORE] = "Frame from before this file",
}

-- Lines of a tap.
N.sertap_lines = {
  [0] = "Shared bus",
  [1] = "First direction",
  [2] = "Second direction",
}

-- Parity of a character.
N.sertap_parities = {
  [0] = "None",
  [1] = "Even",
  [2] = "Odd",
  [3] = "Mark",
  [4] = "Space",
}

-- Stop bits of a character, in half bits.
N.sertap_stop_bits = {
  [2] = "1",
  [3] = "1.5",
  [4] = "2",
}

-- How characters were cut into frames.
N.sertap_framings = {
  [0x00] = "SIS",
  [0x01] = "3964R",
  [0x02] = "ASCII",
  [0xFF] = "Silence",
}

-- Events of the tap.
K.SERTAP_CAPTURE_STARTED = 1
K.SERTAP_CHARACTERS_LOST = 3
K.SERTAP_ADAPTER_LOST = 4
K.SERTAP_LIMITS_TOLD = 6
N.sertap_events = {
  [0] = "None",
  [K.SERTAP_CAPTURE_STARTED] = "Capture started",
  [2] = "Line settings changed",
  [K.SERTAP_CHARACTERS_LOST] = "Characters lost",
  [K.SERTAP_ADAPTER_LOST] = "Adapter lost",
  [5] = "Marker",
  [K.SERTAP_LIMITS_TOLD] = "Limits told by the user",
  [7] = "Told before",
}

-- Wireshark's states of a checksum.
N.checksum_states = {
  [0] = "Bad",
  [1] = "Good",
  [2] = "Unverified",
}

-- Verdicts on a time with its uncertainty (chapter 10).
K.TIME_OK = 0
K.TIME_EXCEEDED = 1
K.TIME_UNRESOLVED = 2
N.verdicts = {
  [K.TIME_OK] = "ok",
  [K.TIME_EXCEEDED] = "exceeded",
  [K.TIME_UNRESOLVED] = "unresolved: the times do not decide",
}

-- What a character or block of 3964R means, judged by what came before.
K.P3964R_ASKS = 0
K.P3964R_BOTH_ASK = 1
K.P3964R_GRANTS = 2
K.P3964R_REFUSES_REQUEST = 3
K.P3964R_BLOCK = 4
K.P3964R_ACKNOWLEDGES = 5
K.P3964R_REFUSES_BLOCK = 6
K.P3964R_OUT_OF_PLACE = 7
N.procedure_meanings = {
  [K.P3964R_ASKS] = "asks to send",
  [K.P3964R_BOTH_ASK] = "asks to send, as the partner does: the one with low priority gives way",
  [K.P3964R_GRANTS] = "ready to receive",
  [K.P3964R_REFUSES_REQUEST] = "not ready to receive",
  [K.P3964R_BLOCK] = "block",
  [K.P3964R_ACKNOWLEDGES] = "block received",
  [K.P3964R_REFUSES_BLOCK] = "block refused: it comes again",
  [K.P3964R_OUT_OF_PLACE] = "nothing to answer",
}

-- Characters of 3964R.
K.P3964R_STX = 0x02
K.P3964R_DLE = 0x10
K.P3964R_NAK = 0x15
N.procedure_characters = {
  [K.P3964R_STX] = "STX",
  [K.P3964R_DLE] = "DLE",
  [K.P3964R_NAK] = "NAK",
}

-- Verdicts on a time of 3964R.
N.procedure_verdicts = {
  [0] = "OK",
  [1] = "Exceeded",
  [2] = "Unresolved",
}

-- Commands on ARCNET (SYNAX chapter 7); an answer is a TO.
K.ARCNET7F_TO = 0
K.ARCNET7F_FETCH = 1
N.arcnet7f_commands = {
  [K.ARCNET7F_TO] = "TO",
  [K.ARCNET7F_FETCH] = "FETCH",
}

-- Data types on ARCNET (SYNAX p. 7-9, 7-10, 7-21).
K.ARCNET7F_WORD_ARRAY = 5
N.arcnet7f_types = {
  [K.ARCNET7F_WORD_ARRAY] = "Word array",
}

-- Commands of RK512; Siemens alone has the last one.
K.RK512_SEND = 0x41
K.RK512_FETCH = 0x45
N.rk512_commands = {
  [K.RK512_SEND] = "SEND",
  [K.RK512_FETCH] = "FETCH",
  [0x4F] = "SEND to an extended data block",
}

-- Kinds of data of RK512; SYNAX has data blocks only.
N.rk512_kinds = {
  [0x44] = "Data block",
  [0x58] = "Extended data block",
  [0x45] = "Inputs",
  [0x41] = "Outputs",
  [0x4D] = "Flags",
  [0x54] = "Timers",
  [0x5A] = "Counters",
}

-- Siemens' numbers; SYNAX' table is lost.
N.rk512_errors = {
  [0x00] = "No error",
  [0x0A] = "Access to the area not possible",
  [0x0C] = "Wrong data type",
  [0x10] = "Telegram not supported",
  [0x12] = "Object type not supported",
  [0x14] = "Block not found, or its number not allowed",
  [0x16] = "Unknown command",
  [0x2A] = "PLC stopped",
  [0x32] = "Block locked by its coordination flag",
  [0x34] = "Wrong length",
  [0x36] = "Follow-up without a command",
}

-- First byte of a telegram of RK512.
N.rk512_telegrams = {
  [0x00] = "First telegram",
  [0xFF] = "Follow-up",
}

-- What is done with an object.
K.SYNAXOBJ_READ_ANSWER = 0
K.SYNAXOBJ_WRITE_REQUEST = 1
K.SYNAXOBJ_READ_REQUEST = 2
K.SYNAXOBJ_WRITE_ANSWER = 3
N.synaxobj_operations = {
  [K.SYNAXOBJ_READ_ANSWER] = "read answer",
  [K.SYNAXOBJ_WRITE_REQUEST] = "write request",
  [K.SYNAXOBJ_READ_REQUEST] = "read request",
  [K.SYNAXOBJ_WRITE_ANSWER] = "write answer",
}

-- Objects (SYNAX chapter 2). The last three control the multiplex channel (p. 2-15 and 5-5). Its control word holds
-- Index_out_c, Index_in_c and RR, its status word RA (p. 2-12): no document says which object and which bits.
K.SYNAXOBJ_DIAGNOSIS_FIELDBUS = 0x5FF0
K.SYNAXOBJ_STATUS_FIELDBUS = 0x5FF2
K.SYNAXOBJ_FAULT_CODE_PPC = 0x5FF6
N.synaxobj_names = {
  [0x5E70] = "Data exchange, 16 bytes",
  [0x5E71] = "Data exchange, 32 bytes",
  [0x5E72] = "Data exchange, 64 bytes",
  [0x5E73] = "Data exchange, 128 bytes",
  [K.SYNAXOBJ_DIAGNOSIS_FIELDBUS] = "Diagnosis fieldbus",
  [K.SYNAXOBJ_STATUS_FIELDBUS] = "Status fieldbus",
  [0x5FF5] = "Written by the PPC, name not known",
  [K.SYNAXOBJ_FAULT_CODE_PPC] = "Fault code PPC",
  [0x5FFC] = "Control of the multiplex channel",
  [0x5FFD] = "Control of the multiplex channel",
  [0x5FFE] = "Control of the multiplex channel",
}

-- Services of Interbus PCP, as NIBA-01 prints them.
N.synaxpcp_services = {
  [0x0081] = "Read request",
  [0x0082] = "Write request",
  [0x0086] = "Status request",
  [0x0087] = "Identify request",
  [0x0088] = "Get OV request",
  [0x008B] = "Initiate request",
  [0x008D] = "Abort request",
  [0x00A1] = "Read response",
  [0x00A2] = "Write response",
  [0x00AB] = "Initiate response",
  [0x00AC] = "Initiate error response",
  [0x0181] = "Read confirmation",
  [0x0182] = "Write confirmation",
  [0x0186] = "Status confirmation",
  [0x0187] = "Identify confirmation",
  [0x0188] = "Get OV confirmation",
  [0x018B] = "Initiate confirmation",
  [0x018C] = "Initiate error confirmation",
  [0x01A1] = "Read indication",
  [0x01A2] = "Write indication",
  [0x01AB] = "Initiate indication",
  [0x01AD] = "Abort indication",
}

-- Error class, code and additional code of Interbus PCP as one number, as NIBA-01 prints them.
N.synaxpcp_errors = {
  [0x06030000] = "no access",
  [0x06050011] = "invalid subindex",
  [0x06050012] = "data too long",
  [0x06050013] = "data too short",
  [0x06060000] = "the object is not a parameter",
  [0x06070000] = "the object does not exist",
  [0x08000000] = "the service cannot be executed",
  [0x08000020] = "the service cannot be executed now",
}

-- Directions of process data.
K.SYNAXPD_TO_PPC = 1
K.SYNAXPD_FROM_PPC = 2
N.synaxpd_directions = {
  [K.SYNAXPD_TO_PPC] = "to the PPC",
  [K.SYNAXPD_FROM_PPC] = "from the PPC",
}

-- Formats of the parameter channel (SYNAX chapter 3). The code of the short format 3 (p. 3-17) is not known.
K.SYNAXPK_DRIVE_SHORT_1 = 0x00
K.SYNAXPK_A_SHORT_1 = 0x01
K.SYNAXPK_SIS_FORMAT = 0x0B
N.channel_formats = {
  [K.SYNAXPK_DRIVE_SHORT_1] = "S/P parameter, short format 1",
  [K.SYNAXPK_A_SHORT_1] = "A parameter, short format 1",
  [K.SYNAXPK_SIS_FORMAT] = "Indramat SIS",
  [0x0F] = "Basic state",
}

-- Who has sent a word of the parameter channel.
K.SYNAXPK_MASTER = 1
K.SYNAXPK_SLAVE = 2
N.channel_senders = {
  [K.SYNAXPK_MASTER] = "Master",
  [K.SYNAXPK_SLAVE] = "Slave",
}

-- Errors of the parameter channel itself (FLP p. 11-15); 0x1Fxx from SYNAX p. 3-21.
N.channel_codes = {
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
}

-- Lines of the ASCII protocol of ECODRIVE and IndraDrive, as MPH-02 (p. 10-86 to 10-91) and public clients have them.
K.SISASCII_TEXT = 0
K.SISASCII_OPEN = 1
K.SISASCII_PROMPT = 2
K.SISASCII_READ = 3
K.SISASCII_WRITE = 4
K.SISASCII_ELEMENT = 5
K.SISASCII_ASKS = 6
K.SISASCII_ERROR = 7
K.SISASCII_ECHO = 8
K.SISASCII_ANSWER = 9
K.SISASCII_END = 10
N.ascii_kinds = {
  [K.SISASCII_TEXT] = "Text",
  [K.SISASCII_OPEN] = "Open drive",
  [K.SISASCII_PROMPT] = "Prompt of drive",
  [K.SISASCII_READ] = "Read parameter",
  [K.SISASCII_WRITE] = "Write parameter",
  [K.SISASCII_ELEMENT] = "List element",
  [K.SISASCII_ASKS] = "Asks for a list element",
  [K.SISASCII_ERROR] = "Error",
  [K.SISASCII_ECHO] = "Echo",
  [K.SISASCII_ANSWER] = "Answer",
  [K.SISASCII_END] = "End of list",
}

-- Errors that only the ASCII protocol has (MPH-02, fig. 10-51); the others are those of parameter services.
N.errors_ascii = {
  [0x9001] = "Characters not recognized",
  [0x9002] = "Wrong type of parameter",
  [0x9003] = "Wrong number of the parameter set",
  [0x9004] = "Input not recognized",
  [0x9005] = "Element not defined",
  [0x9006] = "Neither r nor w",
  [0x9007] = "Wrong character in the data",
}

-- Names of parameters of axes (kind A, set 0), from SYNAX' interface manual.
N.parameters_a = {
  [4] = "Additive position command value, target value",
  [56] = "Set-up position 0",
  [60] = "Fine adjustment",
}

-- Names of parameters of the control (kind C, set 0), from SYNAX' interface manual. Of C-0-0188 the rest is cut off.
N.parameters_c = {
  [1] = "Switch-on delay time",
  [29] = "Jogging time constant",
  [33] = "Host communication, control word",
  [46] = "General diagnostic flag",
  [57] = "Error number of the serial interface",
  [58] = "Configuration list of data block 101",
  [59] = "Configuration list of data block 102",
  [60] = "Configuration list of data block 103",
  [61] = "Configuration list of data block 104",
  [62] = "Configuration list of data block 105",
  [63] = "Configuration list of data block 106",
  [64] = "Configuration list of data block 107",
  [65] = "Configuration list of data block 108",
  [66] = "Master axis, position feedback value",
  [124] = "Timeout of the service channel",
  [125] = "Fieldbus address",
  [127] = "Fieldbus/Ethernet 1, configuration list of the process input data",
  [129] = "Fieldbus control bits",
  [157] = "Data blocks, ident numbers of the configurable S and P parameters",
  [188] = "Ethernet 2, configuration list",
  [193] = "PPC, standard gateway",
  [194] = "PPC, UDP ports",
  [197] = "End of the static part of a configuration list",
  [198] = "End of a multiplex level of a configuration list",
}

-- Data blocks of SYNAX200 that have a meaning of their own (chapters 7 and 8).
K.SYNAX_BLOCK_IO = 99
K.SYNAX_BLOCK_MODE = 100
N.synax_blocks = {
  {98, 98, "cancel a transmission with follow-ups"},
  {99, 99, "inputs and outputs of the PPC"},
  {100, 100, "mode of the PPC"},
  {101, 116, "freely configured"},
}
-- end of codes

--- limits: made by plugin/protocol/generate.py from limits.toml; edit there

-- Bytes of a packet in which bare telegrams may begin. Wireshark refuses a tree of more than a million items, and a
-- tap's queue holds 5,000.
K.MOST_DISSECTED = 32768

-- Transfers under way on one line; a device has one at a time.
K.MOST_OPEN = 256

-- Pieces of a transfer: 64 KB in pieces of 8 bytes. Wireshark searches all of them for each.
K.MOST_PIECES = 8192

-- Bytes of a list. More means that its last piece was lost.
K.MOST_LIST = 65535

-- Devices of one type that are asked for an attribute. More would say the same.
K.MOST_TWINS = 8

-- Elements of a list in the text of its value.
K.SHOWN_IN_LIST = 4

-- Elements of a list in the tree: more than a SERCOS list can have. Wireshark's limit is ten times that.
K.SHOWN_IN_TREE = 100000

-- Characters of a name in a node identification (chapter 3).
K.MOST_CHARACTERS = 40

-- Bytes of the memory in a reaction (chapter 5.4).
K.MOST_READ = 244

-- Bytes of the memory in a command (chapter 5.7).
K.MOST_PROGRAMMED = 240

-- Bytes of a parameter in a reaction (chapters 8.2 and 8.3). IndraDrive sends up to 245.
K.MOST_PARAMETER_READ = 236

-- Bytes of a parameter in a command (chapters 8.6 and 8.7). IndraDrive takes up to 243.
K.MOST_PARAMETER_WRITTEN = 234

-- Bytes of a command of Telnet. More means that its end was lost.
K.MOST_TELNET = 64

-- The time of a character at most, in ns: 12 bits at 9600 Bd. SIS knows no slower rate (chapter 7.1).
K.LONGEST_CHARACTER = 1250000

-- Bytes of a line of the ASCII protocol, as in capture/sistap/tap/records/framer.py. TCP waits for the rest of fewer.
K.SISASCII_MOST_LINE = 4096

-- Tries to connect, and to send a block.
K.P3964R_MOST_TRIES = 6

-- The wait for an answer: Siemens' time, as SYNAX's own is not documented.
K.P3964R_QVZ_MS = 2000

-- The wait for the next try after a refusal.
K.P3964R_BLOCK_WAIT_MS = 4000

-- Words of data block 99 (page 8-8).
K.RK512_MOST_IO_WORDS = 32

-- Bytes of a command; for more, bit 1 of the info access is 0 (page 8-18).
K.RK512_MOST_AT_ONCE = 1024

-- Bytes of data in a telegram; what is more comes in follow-ups (page 8-29).
K.RK512_MOST_IN_TELEGRAM = 128

-- Bytes of data in the parameter channel: it has six words (SYNAX, page 3-3).
K.SYNAXPK_MOST_DATA = 10
-- end of limits

--- services: made by plugin/protocol/generate.py from services.toml; edit there

-- Reactions of these ranges begin with a status byte.
K.WITH_STATUS = {{0x00, 0x1F}, {0x80, 0x9F}}
-- The useful data of these ranges begin with control byte and device address.
K.WITH_CONTROL = {{0x10, 0x11}, {0x1E, 0x1F}}
-- Services of product groups with the layout of a general one; K.LIKE_IF_SET: if a preference is set.
K.LIKE = {
  [0x80] = 0x10,
  [0x81] = 0x11,
  [0x8E] = 0x1E,
  [0x8F] = 0x1F,
  [0x90] = 0x10,
  [0x91] = 0x11,
  [0x92] = 0x12,
  [0x9D] = 0x1D,
  [0x9E] = 0x1E,
  [0x9F] = 0x1F,
}
K.LIKE_IF_SET = {
  ecodrive_phases = {[0x82] = 0x12, [0x8D] = 0x1D},
  clc_as_sercos = {[0xC0] = 0x10, [0xC1] = 0x11, [0xC2] = 0x12, [0xCD] = 0x1D, [0xCE] = 0x1E, [0xCF] = 0x1F},
}
-- What follows a subservice: field, bytes (0: the rest), may be missing, codes.
K.LAYOUTS = {
  [0x00] = { -- identification
    subservices = N.subservices_identification,
    [0x01] = {
      command = {},
      reaction = {{"version", 0}},
    },
    [0x02] = {
      command = {},
      reaction = {{"firmware", 0}},
    },
    [0x03] = {
      command = {},
      reaction = {{"type_key", 0}},
    },
    [0x04] = {
      command = {},
      reaction = {{"init_baud_mask", 1}},
    },
  },
  [0x02] = { -- flash
    subservices = N.subservices_flash,
    errors = N.errors_flash,
    [0x90] = {
      command = {{"flash_target", 1, false, N.shutdown_targets}, {"flash_address", 4}},
      reaction = {},
    },
    [0x91] = {
      command = {{"flash_address", 4}},
      reaction = {},
    },
    [0x92] = {
      command = {{"flash_address", 4}, {"flash_length", 1}},
      reaction = {{"data", 0}},
    },
    [0x93] = {
      command = {},
      reaction = {{"flash_address", 4}},
    },
    [0x94] = {
      command = {{"flash_address", 4}, {"flash_length", 4}},
      reaction = {},
    },
    [0x96] = {
      command = {{"flash_address", 4}, {"flash_device_type", 1, false, N.device_types}, {"data", 0}},
      reaction = {},
    },
    [0x97] = {
      command = {{"flash_address", 4}, {"flash_length", 4}},
      reaction = {{"flash_crc32", 4, true}},
    },
    [0x9F] = {
      command = {},
      reaction = {},
    },
  },
  [0x03] = { -- initialization
    subservices = N.subservices_initialization,
    errors = N.errors_initialization,
    [0x01] = {
      command = {{"init_time", 2}},
      reaction = {},
    },
    [0x02] = {
      command = {{"init_time", 2}},
      reaction = {},
    },
    [0x03] = {
      command = {{"init_time", 2}},
      reaction = {},
    },
    [0x07] = {
      command = {{"init_baud_mask", 1}},
      reaction = {},
    },
    [0x08] = {
      command = {{"init_test_time", 2}, {"init_baud_mask", 1}},
      reaction = {},
    },
    [0xFF] = {
      command = {},
      reaction = {},
    },
  },
}
-- end of services

--- names: made by plugin/protocol/generate.py from names.toml; edit there

N.s_names = {
  [1] = "Control unit cycle time (tNcyc)",
  [2] = "Communication cycle time (tScyc)",
  [11] = "Class 1 diagnostic",
  [12] = "Class 2 diagnostic",
  [14] = "Interface status",
  [15] = "Telegram Type",
  [16] = "Configuration list of AT",
  [17] = "IDN-list of all operation data",
  [18] = "IDN-list of operation data for CP2",
  [19] = "IDN-list of operation data for CP3",
  [21] = "IDN-list of invalid operation data for CP2",
  [22] = "IDN-list of invalid operation data for CP3",
  [24] = "Configuration list of MDT",
  [25] = "IDN-list of all procedure commands",
  [26] = "Configuration list for signal status word",
  [27] = "Configuration list for signal control word",
  [28] = "MST error counter",
  [29] = "MDT error counter",
  [32] = "Primary operation mode",
  [36] = "Velocity command value",
  [37] = "Additive velocity command value",
  [38] = "Positive velocity limit value",
  [39] = "Negative velocity limit value",
  [40] = "Velocity feedback value 1",
  [41] = "Homing velocity",
  [42] = "Homing acceleration",
  [43] = "Velocity polarity parameter",
  [44] = "Velocity data scaling type",
  [45] = "Velocity data scaling factor",
  [46] = "Velocity data scaling exponent",
  [47] = "Position command value",
  [48] = "Additive position command value",
  [49] = "Positive position limit value",
  [50] = "Negative position limit value",
  [51] = "Position feedback value 1 (motor feedback)",
  [52] = "Reference distance 1",
  [53] = "Position feedback value 2 (external feedback)",
  [54] = "Reference distance 2",
  [55] = "Position polarity parameter",
  [57] = "Position window",
  [58] = "Reversal clearance",
  [59] = "Position switch flag parameter",
  [60] = "Position switches (position switch points on 1-16)",
  [76] = "Position data scaling type",
  [77] = "Linear position data scaling factor",
  [78] = "Linear position data scaling exponent",
  [79] = "Rotational position resolution",
  [80] = "Torque command value",
  [81] = "Additive torque command value",
  [82] = "Positive torque limit value",
  [83] = "Negative torque limit value",
  [84] = "Torque feedback value",
  [85] = "Torque polarity parameter",
  [86] = "Torque/force data scaling type",
  [91] = "Bipolar velocity limit value",
  [92] = "Bipolar torque limit value",
  [93] = "Torque/force scaling data factor",
  [94] = "Torque/force scaling data exponent",
  [95] = "Diagnostic message",
  [96] = "Slave arrangement (SLKN)",
  [97] = "Mask class 2 diagnostic",
  [98] = "Mask class 3 diagnostic",
  [99] = "Reset class 1 diagnostic",
  [100] = "Velocity loop proportional gain",
  [101] = "Velocity loop integral action time",
  [102] = "Velocity loop differential time",
  [103] = "Modulo value",
  [104] = "Position loop KV-factor",
  [105] = "Position loop integral action time",
  [106] = "Current loop proportional gain 1",
  [107] = "Current loop integral action time 1",
  [108] = "Feedrate override",
  [109] = "Motor peak current",
  [110] = "Amplifier peak current",
  [111] = "Motor continuous stall current",
  [112] = "Amplifier rated current",
  [113] = "Maximum motor speed",
  [114] = "Load limit of the motor",
  [115] = "Position feedback 2 type",
  [116] = "Resolution of feedback 1",
  [117] = "Resolution of feedback 2",
  [118] = "Resolution of linear feedback",
  [119] = "Current loop proportional gain 2",
  [120] = "Current loop integral action time 2",
  [121] = "Input revolutions of load gear",
  [122] = "Output revolutions of load gear",
  [123] = "Feed constant",
  [124] = "Standstill window",
  [125] = "Velocity threshold (nx)",
  [126] = "Torque threshold (Tx)",
  [127] = "CP3 transition check",
  [128] = "CP4 transition check",
  [129] = "Manufacturer class 1 diagnostic",
  [130] = "Probe value 1 positive edge",
  [131] = "Probe value 1 negative edge",
  [132] = "Probe value 2 positive edge",
  [133] = "Probe value 2 negative edge",
  [134] = "Drive control",
  [135] = "Drive status",
  [136] = "Positive acceleration limit value",
  [137] = "Negative acceleration limit value",
  [138] = "Bipolar acceleration limit value",
  [139] = "Park axis procedure command",
  [143] = "SERCOS Interface version",
  [144] = "Signal status word",
  [145] = "Signal control word",
  [146] = "Control unit controlled homing procedure command",
  [147] = "Homing parameter",
  [148] = "Drive controlled homing procedure command",
  [149] = "Position drive stop procedure command",
  [150] = "Reference offset 1",
  [151] = "Reference offset 2",
  [152] = "Position spindle procedure command",
  [153] = "Spindle angle position",
  [154] = "Spindle positioning parameter",
  [155] = "Friction torque compensation",
  [156] = "Velocity feedback value 2",
  [157] = "Velocity window",
  [158] = "Power threshold (Px)",
  [159] = "Monitoring window",
  [161] = "Acceleration data scaling factor",
  [162] = "Acceleration data scaling exponent",
  [163] = "Weight counterbalance",
  [164] = "Acceleration feedback value 1",
  [165] = "Distance-coded reference marks A",
  [166] = "Distance-coded reference marks B",
  [167] = "Frequency limit of feedback 1",
  [169] = "Probe control",
  [170] = "Probing cycle procedure command",
  [171] = "Calculate displacement procedure command",
  [172] = "Displacement to the referenced system procedure command",
  [173] = "Marker position A",
  [174] = "Marker position B",
  [175] = "Displacement parameter 1",
  [176] = "Displacement parameter 2",
  [177] = "Absolute distance 1",
  [178] = "Absolute distance 2",
  [179] = "Probe status",
  [180] = "Spindle relative offset",
  [181] = "Manufacturer class 2 diagnostic",
  [183] = "Synchronization velocity window",
  [184] = "Synchronization velocity error limit",
  [185] = "Length of the configurable data record in the AT",
  [186] = "Length of the configurable data record in the MDT",
  [187] = "IDN list of configurable data in the AT",
  [188] = "IDN list of configurable data in the MDT",
  [189] = "Following distance",
  [190] = "Drive controlled gear engaging procedure command",
  [191] = "Cancel reference point procedure command",
  [192] = "IDN-list of all backup operation data",
  [193] = "Positioning jerk",
  [194] = "Acceleration command time",
  [195] = "Acceleration feedback value 2",
  [196] = "Motor rated current",
  [197] = "Set coordinate system procedure command",
  [198] = "Initial coordinate value",
  [199] = "Shift coordinate system procedure command",
  [200] = "Amplifier warning temperature",
  [201] = "Motor warning temperature",
  [202] = "Cooling error warning temperature",
  [203] = "Amplifier shut-down temperature",
  [204] = "Motor shut-down temperature",
  [205] = "Cooling error shut-down temperature",
  [206] = "Drive on delay time",
  [207] = "Drive off delay time",
  [208] = "Temperature data scaling type",
  [209] = "Lower adaptation limit",
  [210] = "Upper adaptation limit",
  [211] = "Adaptation proportional gain",
  [212] = "Adaptation integral action time",
  [213] = "Engaging dither amplitude",
  [214] = "Average engaging speed",
  [215] = "Engaging dither period",
  [216] = "Switch parameter set procedure command",
  [217] = "Parameter set preselection",
  [218] = "Gear-ration preselection",
  [219] = "IDN-list of parameter set",
  [220] = "Minimum spindle speed",
  [221] = "Maximum spindle speed",
  [222] = "Spindle positioning speed",
  [223] = "Drive controlled synchronous operation procedure command",
  [224] = "Lead Spindle Address",
  [225] = "Synchronous spindle revolutions",
  [226] = "Lead spindle revolutions",
  [227] = "Synchronous spindle revolutions",
  [228] = "Synchronization position window",
  [229] = "Synchronization position error limit",
  [230] = "Synchronization position offset",
  [254] = "Actual parameter set",
  [255] = "Actual gear ration",
  [256] = "Multiplication factor 1",
  [257] = "Multiplication factor 2",
  [258] = "Target position",
  [259] = "Positioning velocity",
  [260] = "Positioning acceleration",
  [261] = "Coarse position window",
  [262] = "Load defaults procedure command",
  [263] = "Load working memory procedure command",
  [264] = "Backup working memory procedure command",
  [265] = "Language selection",
  [266] = "List of available languages",
  [267] = "Password",
  [268] = "Angular setting",
  [269] = "Storage mode",
  [270] = "IDN-list of selected backup operation data",
  [272] = "Velocity window percentage",
  [273] = "Maximum drive off delay time",
  [275] = "Coordinate offset value",
  [276] = "Return to Modulo range procedure command",
  [277] = "Position feedback 1 type",
  [278] = "Maximum travel range",
  [279] = "IDN list of password protected data",
  [280] = "Underflow threshold",
  [282] = "Positioning command value",
  [283] = "Current coordinate offset",
  [292] = "List of supported operation modes",
  [293] = "Selectively backup working memory procedure command",
  [294] = "Divider modulo value",
  [295] = "Drive enable delay time",
  [296] = "Velocity feed forward gain",
  [297] = "Homing distance",
  [298] = "Suggest home switch distance",
  [299] = "Home switch offset 1",
  [300] = "Real-time control bit 1",
  [301] = "Allocation of real-time control bit 1",
  [302] = "Real-time control bit 2",
  [303] = "Allocation of real-time control bit 2",
  [304] = "Real-time status bit 1",
  [305] = "Allocation of real-time status bit 1",
  [306] = "Real-time status-bit 2",
  [307] = "Allocation of real-time status bit 2",
  [308] = "Synchronization operation status",
  [309] = "Synchronization error status",
  [310] = "Overload warning",
  [311] = "Amplifier overtemperature warning",
  [312] = "Motor overtemperature warning",
  [313] = "Cooling error warning",
  [315] = "Positioning velocity higher than n Limit",
  [323] = "Target position outside of travel range",
  [326] = "Parameter checksum",
  [327] = "IDN list of checksum parameter",
  [328] = "Bit number allocation list for signal status word",
  [329] = "Bit number allocation list for signal control word",
  [330] = "Status 'nfeedback = ncommand'",
  [331] = "Status 'nfeedback = 0'",
  [332] = "Status 'nfeedback less then nx'",
  [333] = "Status 'T higher than Tx'",
  [334] = "Status 'T greater than Tlimit '",
  [335] = "Status 'ncommand greater than nlimit'",
  [336] = "Status 'In position'",
  [337] = "Status 'P greater Px'",
  [338] = "Status 'Position feedback = active target position'",
  [339] = "Status 'nfeedback less than minimum spindle speed'",
  [340] = "Status 'nfeedback exceeds maximum spindle speed'",
  [341] = "Status 'In Coarse position'",
  [342] = "Status 'Target position attained'",
  [343] = "Status 'Interpolator halted'",
  [346] = "Positioning control",
  [347] = "Velocity error",
  [348] = "Acceleration feed forward gain",
  [349] = "Bipolar jerk limit",
  [356] = "Distance home switch - marker puls",
  [357] = "Marker pulse distance",
  [358] = "Home switch offset 2",
  [359] = "Positioning deceleration",
  [360] = "MDT data container",
  [362] = "MDT data container A list index",
  [364] = "AT data container A1",
  [366] = "AT data container A list index",
  [368] = "Data container A pointer",
  [370] = "MDT data container A/B configuration list",
  [371] = "AT data container A/B configuration list",
  [372] = "Drive Halt acceleration bipolar",
  [377] = "Velocity feedback monitoring window",
  [378] = "Absolute encoder range 1",
  [379] = "Absolute encoder range 2",
  [380] = "DC bus voltage",
  [381] = "DC bus current",
  [382] = "DC bus power",
  [383] = "Motor temperature",
  [384] = "Amplifier temperature",
  [385] = "Active power",
  [386] = "Active position feedback value",
  [387] = "Power overload",
  [388] = "Braking current limit",
  [389] = "Effective current",
  [390] = "DiagnosticNumber",
  [391] = "Position feedback monitoring window",
  [392] = "Velocity feedback filter",
  [393] = "Command value mode",
  [398] = "IDN list of configurable real-time/status bits",
  [399] = "IDN list of configurable real-time/control bits",
  [400] = "Home switch",
  [401] = "Probe 1",
  [402] = "Probe 2",
  [403] = "Position feedback value status",
  [404] = "Position command value status",
  [405] = "Probe 1 enable",
  [406] = "Probe 2 enable",
  [407] = "Homing enable",
  [408] = "Reference marker pulse registered",
  [409] = "Probe 1 positive latched",
  [410] = "Probe 1 negative latched",
  [411] = "Probe 2 positive latched",
  [412] = "Probe 2 negative latched",
  [413] = "Bit number allocation of real-time control bit 1",
  [414] = "Bit number allocation of real-time control bit 2",
  [415] = "Bit number allocation of real-time status bit 1",
  [416] = "Bit number allocation of real-time status bit 2",
  [417] = "Positioning velocity threshold in modulo mode",
  [418] = "Target position window in modulo mode",
  [419] = "Positioning acknowledge",
  [420] = "Activate parameterization level procedure command (PL)",
  [422] = "Exit parameterization level procedure command",
  [423] = "IDN-list of invalid data for parameterization level",
  [426] = "Measuring data allocation 1",
  [427] = "Measuring data allocation 2",
  [428] = "IDN list of configurable measuring data",
  [429] = "Emergency stop deceleration",
  [430] = "Active target position",
  [431] = "Spindle positioning acceleration bipolar",
  [437] = "Positioning status",
  [446] = "Ramp reference velocity",
  [447] = "Set absolute position procedure command",
  [448] = "Set absolute position control word",
  [460] = "Position switches (position switch points off 1-16)",
  [476] = "Position switch control",
  [477] = "Position switch hysteresis",
  [478] = "Limit switch status",
  [509] = "Extended probe control",
  [510] = "Difference value probe 1",
  [511] = "Difference value probe 2",
  [512] = "Start position probing window 1",
  [513] = "End position probing window 1",
  [514] = "Start position probing window 2",
  [515] = "End position probing window 2",
  [516] = "Marker losses probe 1",
  [517] = "Marker losses probe 2",
  [518] = "Maximum marker losses probe 1",
  [519] = "Maximum marker losses probe 2",
  [520] = "Axis control word",
  [521] = "Axis status word",
  [522] = "Difference value 1 latched",
  [523] = "Difference value 2 latched",
  [524] = "Probe 1 delay positive",
  [525] = "Delay Negative Edge, Probe 1",
  [526] = "Delay positive Edge, Probe 2",
  [527] = "Delay Negative Edge, Probe 2",
  [530] = "Clamping torque",
  [531] = "Checksum for backup operation data",
  [532] = "Limit switch control",
  [533] = "Motor continuous stall torque/force",
  [1000] = "SCP Type & Version",
  [1001] = "SERCOS III: Control unit cycle time (tNcyc)",
  [1002] = "SERCOS III: Communication cycle time (tScyc)",
  [1003] = "SERCOS III: Number of successive MDT errors",
  [1005] = "SERCOS III: Feedback value computation time (t5)",
  [1006] = "SERCOS III: AT transmission starting time (t1)",
  [1007] = "SERCOS III: Synchronization time (t8)",
  [1008] = "SERCOS III: Command value valid time (t3)",
  [1009] = "SERCOS III: Device Control offset in MDT",
  [1010] = "SERCOS III: Length of MDT",
  [1011] = "SERCOS III: Device Status offset in AT",
  [1012] = "SERCOS III: Length of AT",
  [1013] = "SERCOS III: SVC offset in MDT",
  [1014] = "SERCOS III: SVC offset in AT",
  [1015] = "SERCOS III: Ring delay",
  [1016] = "SERCOS III: Slave delay",
  [1017] = "SERCOS III: Transmission starting time IP channel",
  [1018] = "SERCOS III: SYNC delay",
  [1019] = "SERCOS III: MAC address",
  [1020] = "SERCOS III: IP address",
  [1021] = "SERCOS III: Network mask",
  [1022] = "SERCOS III: Gateway address",
  [1023] = "SERCOS III: Sync jitter",
  [1024] = "SERCOS III: Ring control - node control",
  [1025] = "SERCOS III: Ring status - node status",
  [1026] = "SERCOS III: Hardware identification",
  [1028] = "SERCOS III: Error counter MDT0 MST",
  [1029] = "SERCOS III: Error counter MDT0-3",
  [1030] = "SERCOS III: Error counter AT0-3",
  [1031] = "Signal assignment Port 1 & Port 2",
  [1035] = "Error counter Port1 and Port2",
  [1040] = "SERCOSAddress",
  [1041] = "AT Command value valid time (t9)",
  [1044] = "Device Control",
  [1045] = "Device Status",
  [1046] = "IDN-list of SERCOS addresses in device",
  [1134] = "SERCOS III: Device control",
  [1135] = "SERCOS III: Device status",
}
-- end of names

--- fields: made by plugin/protocol/generate.py from fields.toml and experts.toml; edit there

-- The masks of fields that are bits of another.
K.SERTAP_SAME_READ = 0x01
K.SERTAP_ERROR_CHARACTER = 0x02
K.SERTAP_ERROR_BREAK = 0x04
K.SERTAP_ERROR_LOST = 0x08
K.SERTAP_ERROR_UNLOCATED = 0x10
K.SERTAP_INTERVAL_UNKNOWN = 0x20
K.SERTAP_INTERVAL_SATURATED = 0x40
K.PARAMETER_PRODUCT_SPECIFIC = 0x8000
K.PARAMETER_SET = 0x7000
K.PARAMETER_NUMBER = 0xFFF
K.ATTRIBUTE_FACTOR = 0xFFFF
K.ATTRIBUTE_LENGTH = 0x70000
K.ATTRIBUTE_COMMAND = 0x80000
K.ATTRIBUTE_FORMAT = 0x700000
K.ATTRIBUTE_DECIMALS = 0xF000000
K.ATTRIBUTE_PROTECTED_2 = 0x10000000
K.ATTRIBUTE_PROTECTED_3 = 0x20000000
K.ATTRIBUTE_PROTECTED_4 = 0x40000000
K.CONTROL_SUBADDRESSES = 0x07
K.CONTROL_NUMBER = 0x08
K.CONTROL_REACTION = 0x10
K.CONTROL_RESERVED = 0x20
K.CONTROL_WARNING = 0x40
K.CONTROL_ERROR = 0x80
K.CONTROL_RESERVED_BITS = 0xE0
K.CONTROL_STATUS = 0xE0
K.PARAMETER_CONTROL_RESERVED = 0xC3
K.ELEMENT = 0x38
K.TRANSMISSION = 0x04
K.DATA_STATUS_SET = 0x01
K.DATA_STATUS_ENABLED = 0x02
K.DATA_STATUS_NOT_EXECUTED = 0x04
K.DATA_STATUS_IMPOSSIBLE = 0x08
K.DATA_STATUS_INVALID = 0x100
K.SYNAX_INFO_OPEN = 0xFFFC
K.SYNAX_INFO_LAST = 0x02
K.SYNAX_INFO_WRITE = 0x01
K.SYNAXPK_WORD_OPEN = 0xC000
K.SYNAXPK_WORD_ERROR = 0x2000
K.SYNAXPK_WORD_READ = 0x1000
K.SYNAXPK_WORD_BUSY = 0x800
K.SYNAXPK_WORD_LAST = 0x400
K.SYNAXPK_WORD_BIT9 = 0x200
K.SYNAXPK_WORD_TOGGLE = 0x100
K.SYNAXPK_WORD_COUNT = 0xF0
K.SYNAXPK_WORD_FORMAT = 0x0F
K.SYNAXPK_DRIVE_PF = 0x8000
K.SYNAXPK_DRIVE_ERROR = 0x4000
K.SYNAXPK_DRIVE_LAST = 0x2000
K.SYNAXPK_DRIVE_TOGGLE = 0x1000
K.SYNAXPK_DRIVE_FRAGMENT = 0xF00
K.SYNAXPK_DRIVE_LENGTH = 0xFF
K.SYNAXOBJ_DIAGNOSIS_INTERFACE = 0xF000
K.SYNAXOBJ_DIAGNOSIS_FAULT = 0xFF
K.SYNAXOBJ_STATUS_BUS = 0x08
K.SYNAXOBJ_STATUS_MEMORY = 0x03
K.SYNAXOBJ_FAULT_COMMUNICATION = 0xFF00
K.SYNAXOBJ_FAULT_PROCESS_DATA = 0xFF

-- sertap
field("sertap.version", "Version", ftypes.UINT8, base.DEC, nil, 0, "Version of the record's layout")
field("sertap.header_length", "Header length", ftypes.UINT8, base.DEC, nil, 0,
  "Bytes of the record before the characters")
field("sertap.type", "Type", ftypes.UINT8, base.DEC, N.sertap_types, 0,
  "A frame, characters that belong to no frame, an event of the tap, or a frame from before this file")
field("sertap.line", "Line", ftypes.UINT8, base.DEC, N.sertap_lines, 0,
  "The shared bus, or one direction of a full-duplex line")
field("sertap.baud", "Baud rate", ftypes.UINT32, base.DEC, nil, 0,
  "The rate at which the tap listened, in bits per second; 0: not known")
field("sertap.format", "Character format", ftypes.STRING, base.NONE, nil, 0,
  "Data bits, parity and stop bits that the tap listened with")
field("sertap.format.data_bits", "Data bits", ftypes.UINT8, base.DEC, nil, 0, "Data bits of a character")
field("sertap.format.parity", "Parity", ftypes.UINT8, base.DEC, N.sertap_parities, 0, "Parity bit of a character")
field("sertap.format.stop", "Stop bits", ftypes.UINT8, base.DEC, N.sertap_stop_bits, 0, "In half bits")
field("sertap.framing", "Framing", ftypes.UINT8, base.DEC, N.sertap_framings, 0, "By which rule frames are cut")
field("sertap.uncertainty", "Uncertainty of the times", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "How much earlier than recorded a character can have arrived")
field("sertap.count", "Count", ftypes.UINT16, base.DEC, nil, 0, "Characters, or bytes of an event's text")
field("sertap.event", "Event", ftypes.UINT16, base.DEC, N.sertap_events, 0,
  "What happened to the tap, not on the line")
field("sertap.text", "Text", ftypes.STRING, base.NONE, nil, 0,
  "The event in words, such as the adapter and its tuning")
field("sertap.data", "Characters", ftypes.BYTES, base.NONE, nil, 0,
  "All characters of the record, as they were received")
field("sertap.character", "Character", ftypes.UINT8, base.HEX, nil, 0, "One character with its time and its flags")
field("sertap.interval", "Interval", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Since the character before it on this line, arrival to arrival")
field("sertap.interval.max", "Longest interval", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Between two characters of this record")
field("sertap.flags", "Flags", ftypes.UINT8, base.HEX, nil, 0, "How the character arrived, and line errors")
field("sertap.same_read", "Came in the same read as the one before", ftypes.BOOLEAN, 8, nil, 0x01,
  "Both came in one read, so the time between them is not exact")
field("sertap.error.character", "Parity or framing error", ftypes.BOOLEAN, 8, nil, 0x02,
  "The adapter reports a parity or framing error at this character")
field("sertap.error.break", "Break", ftypes.BOOLEAN, 8, nil, 0x04, "The line was held low for longer than a character")
field("sertap.error.lost", "Characters lost before it", ftypes.BOOLEAN, 8, nil, 0x08,
  "The computer or the adapter lost characters before this one")
field("sertap.error.unlocated", "Error somewhere in its read", ftypes.BOOLEAN, 8, nil, 0x10,
  "A line error among the characters that came in this read; the adapter does not say at which one")
field("sertap.interval.unknown", "Interval unknown (first on the line)", ftypes.BOOLEAN, 8, nil, 0x20,
  "This is the first character on the line, so there is none before it")
field("sertap.interval.saturated", "Interval longer than it can be stored", ftypes.BOOLEAN, 8, nil, 0x40,
  "More than 4.29 s passed; the time between the packets is exact")
expert_field("sertap.version.unknown", "MALFORMED", "ERROR", "Unknown version of the record")
expert_field("sertap.header_length.short", "MALFORMED", "ERROR", "The header is shorter than version 1 has it")
expert_field("sertap.count.wrong", "MALFORMED", "ERROR", "The count does not fit")
expert_field("sertap.truncated", "MALFORMED", "ERROR", "The record is cut")
expert_field("sertap.error.character.expert", "CHECKSUM", "WARN", "Parity or framing error on the line")
expert_field("sertap.error.break.expert", "PROTOCOL", "WARN", "Break on the line")
expert_field("sertap.error.lost.expert", "SEQUENCE", "WARN", "Characters were lost before the tap could read them")
expert_field("sertap.error.unlocated.expert", "CHECKSUM", "WARN",
  "A line error, the adapter does not say at which character")
expert_field("sertap.before", "SEQUENCE", "CHAT", "From before this file: learned from, not counted, not judged")
expert_field("sertap.event.expert", "SEQUENCE", "WARN", "The capture has a gap")

-- sis
field("sis.data", "Data", ftypes.BYTES, base.NONE, nil, 0, "The operating data, and nothing else")
field("sis.raw", "Not decoded", ftypes.BYTES, base.NONE, nil, 0, "Bytes that no document explains")
field("sis.value.number", "Number", ftypes.DOUBLE, base.NONE, nil, 0,
  "The value without its unit, for filters, columns and graphs")
field("sis.value.bit", "Bit set", ftypes.STRING, base.NONE, nil, 0,
  "The name of a bit that is set, from the user's table")
field("sis.parameter", "Parameter", ftypes.STRING, base.NONE, nil, 0,
  "Kind, set and number; in a reaction taken from its command")
field("sis.parameter.name", "Name", ftypes.STRING, base.NONE, nil, 0,
  "Read on the bus, from the user's table, or built in; the text says which")
field("sis.parameter.unit", "Unit", ftypes.STRING, base.NONE, nil, 0, "Read on the bus or from the user's table")
field("sis.parameter.minimum", "Minimum", ftypes.STRING, base.NONE, nil, 0,
  "The smallest value allowed, as it was read on the bus")
field("sis.parameter.maximum", "Maximum", ftypes.STRING, base.NONE, nil, 0,
  "The largest value allowed, as it was read on the bus")
field("sis.parameter.type", "Type", ftypes.UINT8, base.DEC, N.parameter_types, 0,
  "A parameter of a drive or one of the control")
field("sis.parameter.product_specific", "Kind", ftypes.BOOLEAN, 16, {"P, product-specific", "S, standard"}, 0x8000,
  "S: standard of SERCOS. P: of this product only")
field("sis.parameter.set", "Parameter set", ftypes.UINT16, base.DEC, nil, 0x7000,
  "One of eight sets that a parameter can have")
field("sis.parameter.number", "Number", ftypes.UINT16, base.DEC, nil, 0xfff, "The number in the set, 0 to 4095")
field("sis.value", "Value", ftypes.STRING, base.NONE, nil, 0, "Scaled, with its unit where that is known")
field("sis.element.name", "Name", ftypes.STRING, base.NONE, nil, 0,
  "The name of the parameter, as the device tells it")
field("sis.element.unit", "Unit", ftypes.STRING, base.NONE, nil, 0,
  "The unit of the parameter, as the device tells it")
field("sis.attribute", "Attribute", ftypes.UINT32, base.HEX, nil, 0,
  "How to read the value: length, format, decimal places, write protection")
field("sis.attribute.factor", "Conversion factor", ftypes.UINT32, base.DEC, nil, 0xffff, "Multiply the value by it")
field("sis.attribute.length", "Length", ftypes.UINT32, base.DEC, N.attribute_lengths, 0x70000,
  "Bytes of the value, or of each element of a list")
field("sis.attribute.command", "Procedure command", ftypes.BOOLEAN, 32, nil, 0x80000,
  "Writing the parameter starts a procedure command")
field("sis.attribute.format", "Format", ftypes.UINT32, base.DEC, N.attribute_formats, 0x700000,
  "How to show the value")
field("sis.attribute.decimals", "Decimal places", ftypes.UINT32, base.DEC, nil, 0xf000000,
  "Digits after the decimal point")
field("sis.attribute.protected_2", "Write-protected in phase 2", ftypes.BOOLEAN, 32, nil, 0x10000000,
  "Cannot be written in phase 2")
field("sis.attribute.protected_3", "Write-protected in phase 3", ftypes.BOOLEAN, 32, nil, 0x20000000,
  "Cannot be written in phase 3")
field("sis.attribute.protected_4", "Write-protected in phase 4", ftypes.BOOLEAN, 32, nil, 0x40000000,
  "Cannot be written in phase 4")
field("sis.list.actual", "Actual length of the list", ftypes.UINT16, base.DEC + base.UNIT_STRING, {" byte", " bytes"},
  0, "Bytes that the list has now; the first word of a list")
field("sis.list.maximum", "Maximum length of the list", ftypes.UINT16, base.DEC + base.UNIT_STRING,
  {" byte", " bytes"}, 0, "Bytes that the list can have; the second word of a list")
field("sis.access", "Access", ftypes.STRING, base.NONE, nil, 0,
  "What was read or written of a parameter, as JSON: for programs")
field("sis.packed", "Fields of this telegram", ftypes.STRING, base.NONE, nil, 0,
  "The fields of a telegram that is not the first of its packet, with the number of values of each: "
    .. "for programs")
field("sis.text", "Text", ftypes.STRING, base.NONE, nil, 0, "Useful data of a product group that are plain ASCII")
field("sis.element_length", "Length", ftypes.UINT8, base.DEC, nil, 0, "Service and body of this element")
field("sis.stream", "Stream", ftypes.UINT32, base.DEC, nil, 0, "One number for each pair of stations")
field("sis.reaction_in", "Reaction in", ftypes.FRAMENUM, base.NONE, frametype.RESPONSE, 0,
  "The packet that answers this command")
field("sis.command_in", "Command in", ftypes.FRAMENUM, base.NONE, frametype.REQUEST, 0,
  "The packet that this reaction answers")
field("sis.reaction_time", "Reaction time", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "From the last character of the command to the first of the reaction; from packet to packet where "
    .. "the times of the characters are not known; not there if both came in one read of the tap, or the "
    .. "clock was set back between them. With an operator terminal BTV05, command and reaction together "
    .. "take 100 ms at most (chapter 10.1)")
field("sis.reaction_time.ms", "Reaction time in ms", ftypes.DOUBLE, base.NONE, nil, 0,
  "For a column of the packet list")
field("sis.repeat_of", "Repeat of", ftypes.FRAMENUM, base.NONE, frametype.RETRANS_PREV, 0,
  "The packet that this command repeats, byte for byte")
field("sis.unanswered_before", "Command before, not answered", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The master's command before this one, where it went on without a reaction")
field("sis.next_command_in", "Next command in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The master's next command, where it went on without a reaction")
field("sis.answered_in", "Answered before in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "An earlier reaction to the same command")
field("sis.routed_from", "Routed from", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The same telegram on the level it came from")
field("sis.service", "Service", ftypes.UINT8, base.HEX + base.RANGE_STRING, N.services, 0,
  "What the telegram asks for; a reaction repeats it")
field("sis.status", "Status", ftypes.UINT8, base.HEX + base.RANGE_STRING, N.status, 0,
  "Whether the command was executed: the first byte of a reaction's useful data")
field("sis.device", "Device address", ftypes.UINT8, base.DEC, nil, 0,
  "Of the device behind the station; its own address, or 0 for the control itself")
field("sis.subservice", "Subservice", ftypes.UINT8, base.HEX, nil, 0, "What exactly the service shall do")
field("sis.error", "Error code", ftypes.UINT16, base.HEX, nil, 0,
  "The full code, where a byte is sent together with its subservice; some codes are followed by advice")
field("sis.phase", "Phase", ftypes.UINT8, base.DEC, nil, 0,
  "Communication phase of SERCOS: 2 parameter mode, 4 operating mode")
field("sis.init.baud_mask", "Baud rate mask", ftypes.UINT8, base.HEX, nil, 0, "One bit for each baud rate; 0: 9600")
field("sis.start", "Start character", ftypes.UINT8, base.HEX, nil, 0, "Every telegram begins with 0x02")
field("sis.checksum", "Checksum", ftypes.UINT8, base.HEX, nil, 0, "Makes the sum of all bytes 0 modulo 256")
field("sis.checksum.status", "Checksum Status", ftypes.UINT8, base.NONE, N.checksum_states, 0,
  "Whether the sum of all bytes is 0; unverified if bytes are missing")
field("sis.length", "Data length", ftypes.UINT8, base.DEC, nil, 0, "Bytes after the static header of 8")
field("sis.length_repeat", "Data length repetition", ftypes.UINT8, base.DEC, nil, 0, "Must equal the data length")
field("sis.control", "Telegram control", ftypes.UINT8, base.HEX, nil, 0,
  "Subaddresses, telegram number, direction; bits 5 to 7 differ between the editions")
field("sis.control.subaddresses", "Subaddresses", ftypes.UINT8, base.DEC, nil, 0x07,
  "How many subaddresses follow the receiver address")
field("sis.control.number", "Telegram number", ftypes.BOOLEAN, 8, {"Present", "Not present"}, 0x08,
  "Whether a telegram number follows the addresses")
field("sis.control.reaction", "Kind", ftypes.BOOLEAN, 8, {"Reaction telegram", "Command telegram"}, 0x10,
  "Command of a master, or reaction of a station")
field("sis.control.reserved", "Reserved", ftypes.BOOLEAN, 8, nil, 0x20, "Not used in the edition IF02")
field("sis.control.warning", "System warning of the sender", ftypes.BOOLEAN, 8, nil, 0x40,
  "The sender has a system warning (IF02)")
field("sis.control.error", "System error of the sender", ftypes.BOOLEAN, 8, nil, 0x80,
  "The sender has a system error (IF02)")
field("sis.control.reserved_bits", "Reserved", ftypes.UINT8, base.HEX, nil, 0xe0, "Not used in a command (ECODRIVE03)")
field("sis.control.status", "Status", ftypes.UINT8, base.DEC, N.control_status_ecodrive03, 0xe0,
  "How far the command is (ECODRIVE03)")
field("sis.sender", "Sender address", ftypes.UINT8, base.DEC, nil, 0,
  "The byte in the header; a reaction keeps the master's")
field("sis.receiver", "Receiver address", ftypes.UINT8, base.DEC, nil, 0,
  "The byte in the header; a reaction keeps the slave's")
field("sis.subaddress", "Subaddress", ftypes.UINT8, base.DEC, nil, 0, "The next station of a route through routers")
field("sis.number", "Telegram number", ftypes.UINT8, base.DEC, nil, 0,
  "Tells a repeated command from a new one; 0: no check")
field("sis.talker", "Talker", ftypes.UINT8, base.DEC, nil, 0,
  "Who really sends: a reaction keeps the command's addresses")
field("sis.listener", "Listener", ftypes.UINT8, base.DEC, nil, 0, "For whom it really is")
field("sis.station", "Station", ftypes.UINT8, base.DEC, nil, 0, "Talker or listener")
field("sis.sequence", "Pieces", ftypes.NONE, base.NONE, nil, 0, "The telegrams that carry the pieces of these data")
field("sis.sequence.piece", "Piece", ftypes.FRAMENUM, base.NONE, nil, 0, "The packet with this piece")
field("sis.sequence.overlap", "Overlap", ftypes.BOOLEAN, base.NONE, nil, 0, "This piece repeats bytes of another")
field("sis.sequence.overlap.conflict", "Overlap with other data", ftypes.BOOLEAN, base.NONE, nil, 0,
  "This piece repeats bytes of another with other contents")
field("sis.sequence.multiple_tails", "Several last pieces", ftypes.BOOLEAN, base.NONE, nil, 0,
  "More than one piece says that it is the last")
field("sis.sequence.too_long", "Piece too long", ftypes.BOOLEAN, base.NONE, nil, 0,
  "This piece goes beyond the end of the data")
field("sis.sequence.error", "Error while putting together", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet in which the pieces did not fit")
field("sis.sequence.count", "Number of pieces", ftypes.UINT32, base.DEC, nil, 0, "How many telegrams carry these data")
field("sis.sequence.whole_in", "The whole is in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet that shows the joined data")
field("sis.sequence.length", "Length of the whole", ftypes.UINT32, base.DEC + base.UNIT_STRING, {" byte", " bytes"}, 0,
  "Bytes of the joined data")
field("sis.sequence.begun_in", "Unfinished transfer begun in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet with the first piece of the transfer that ended unfinished")
field("sis.canceled_service", "Cancelled service", ftypes.UINT8, base.HEX + base.RANGE_STRING, N.services, 0,
  "The transfer of this service shall end")
field("sis.flash.address", "Memory address", ftypes.UINT32, base.HEX, nil, 0,
  "Where in the memory of the drive the operation begins")
field("sis.flash.length", "Length", ftypes.UINT32, base.DEC + base.UNIT_STRING, {" byte", " bytes"}, 0,
  "How many bytes of memory the operation covers")
field("sis.flash.target", "Target", ftypes.UINT8, base.HEX, N.shutdown_targets, 0,
  "The program that runs after the shutdown")
field("sis.flash.device_type", "Device type", ftypes.UINT8, base.HEX, N.device_types, 0,
  "The kind of memory that is programmed")
field("sis.flash.crc32", "CRC32", ftypes.UINT32, base.HEX, nil, 0, "Checksum of the module, as IndraDrive returns it")
field("sis.version", "SIS version", ftypes.STRING, base.NONE, nil, 0,
  "Version of SIS that the station speaks, such as 01V01")
field("sis.firmware", "Firmware (FWA) number", ftypes.STRING, base.NONE, nil, 0, "Which firmware the station runs")
field("sis.type_key", "Device type key", ftypes.STRING, base.NONE, nil, 0, "Which device the station is")
field("sis.init.time", "Time", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "The limit that this telegram sets: TrS, TzA or Tmas")
field("sis.init.test_time", "Duration of the test", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "How long the station stays at the tested baud rate")
field("sis.parameter_control", "Parameter control", ftypes.UINT8, base.HEX, nil, 0,
  "Which element of the parameter, and whether more telegrams follow")
field("sis.parameter_control.reserved", "Reserved", ftypes.UINT8, base.HEX, nil, 0xc3, "Bits that must be 0")
field("sis.element", "Element", ftypes.UINT8, base.DEC, N.elements, 0x38,
  "What is accessed: the value (operating data), its name, unit, attribute or limits")
field("sis.transmission", "Transmission", ftypes.BOOLEAN, 8, {"last", "current, more follows"}, 0x04,
  "Whether this is the last telegram of the transfer")
field("sis.list_offset", "List offset", ftypes.UINT16, base.DEC, nil, 0,
  "Where the segment begins; in words for 0x81 and 0x8E, else in bytes")
field("sis.list_length", "List length", ftypes.UINT16, base.DEC, nil, 0,
  "How long the segment is; in words for 0x81 and 0x8E, else in bytes")
field("sis.data_status", "Data status", ftypes.UINT16, base.HEX, nil, 0, "How far a procedure command is")
field("sis.data_status.set", "Command set", ftypes.BOOLEAN, 16, nil, 0x01, "Somebody has set the command")
field("sis.data_status.enabled", "Command enabled", ftypes.BOOLEAN, 16, nil, 0x02,
  "The command runs; if not set, it is interrupted")
field("sis.data_status.not_executed", "Not yet executed", ftypes.BOOLEAN, 16, nil, 0x04,
  "The command has not ended yet")
field("sis.data_status.impossible", "Execution not possible", ftypes.BOOLEAN, 16, nil, 0x08,
  "The command ended with an error")
field("sis.data_status.invalid", "Operating data invalid", ftypes.BOOLEAN, 16, nil, 0x100,
  "The value cannot be trusted now")
field("sis.phase.switch_in", "Phase switch in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet that asked for the phase switch which this poll observes")
field("sis.phase.switch_time", "Time of the phase switch", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "From its command to the poll that ended it")
field("sis.silence_before", "Silence before", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Since the character before it on this line, arrival to arrival. An operator terminal BTV05 takes "
    .. "its link for lost after 200 ms of silence")
field("sis.silence_before.ms", "Silence before in ms", ftypes.DOUBLE, base.NONE, nil, 0,
  "For a column of the packet list")
field("sis.tza.interval_max", "Longest interval", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Between two characters of the telegram, arrival to arrival; where they came in one read, the most "
    .. "it can have been")
field("sis.tza.interval_max.ms", "Longest interval in ms", ftypes.DOUBLE, base.NONE, nil, 0,
  "For a column of the packet list")
field("sis.tza.position", "Longest interval before character", ftypes.UINT16, base.DEC, nil, 0,
  "Its number in the telegram, from 1")
field("sis.tza.limit", "TzA (longest interval allowed)", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "As the bus was told, or from the preference sis.tza_ms")
field("sis.tza.set_in", "TzA set in", ftypes.FRAMENUM, base.NONE, nil, 0, "The packet that made this limit valid")
field("sis.tza.verdict", "Verdict on TzA", ftypes.UINT8, base.DEC, N.verdicts, 0,
  "Whether the intervals in this telegram keep TzA, with the uncertainty of their times")
field("sis.trs.limit", "TrS (longest reaction time allowed)", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "As the bus was told, or from the preference sis.trs_ms")
field("sis.trs.set_in", "TrS set in", ftypes.FRAMENUM, base.NONE, nil, 0, "The packet that made this limit valid")
field("sis.trs.verdict", "Verdict on TrS", ftypes.UINT8, base.DEC, N.verdicts, 0,
  "Whether this reaction keeps TrS, with the uncertainty of its time")
field("sis.twm.wait", "Wait of the master (TwM)", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Since the end of its command before: of the one that is repeated, or of a broadcast")
field("sis.tmas.before_in", "Master control word before in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet with the master control word before this one")
field("sis.tmas.cycle", "Master control word cycle", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Between two writings of S-0-0134 to the same device, begin to begin")
field("sis.tmas.limit", "Tmas (longest cycle allowed)", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "While the machine moves")
field("sis.tmas.set_in", "Tmas set in", ftypes.FRAMENUM, base.NONE, nil, 0, "The packet that made this limit valid")
field("sis.tmas.verdict", "Verdict on Tmas", ftypes.UINT8, base.DEC, N.verdicts, 0,
  "Whether this master control word keeps Tmas, with the uncertainty of its time")
field("sis.bus.baud", "Baud rate of the bus", ftypes.UINT32, base.DEC + base.UNIT_STRING, {" Bd"}, 0,
  "As the bus was told")
field("sis.bus.baud.set_in", "Baud rate set in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet that made this rate valid")
field("sis.bus.load", "Bus load", ftypes.DOUBLE, base.NONE, nil, 0,
  "Percent of the last second in which there were characters on the line")
expert_field("sis.list.recursion", "PROTOCOL", "ERROR", "Service 0x04 must not be in its own list")
expert_field("sis.command.unanswered", "SEQUENCE", "NOTE", "No reaction before the next command")
expert_field("sis.reaction.unasked", "SEQUENCE", "NOTE", "The command of this reaction is not known")
expert_field("sis.reaction.to_damaged", "SEQUENCE", "CHAT",
  "The answer to a damaged command: allowed only point to point; on a bus the station is silent")
expert_field("sis.reaction.again", "SEQUENCE", "NOTE", "The command was answered before")
expert_field("sis.command.repeat", "SEQUENCE", "NOTE", "The same command again")
expert_field("sis.body.missing", "PROTOCOL", "WARN", "Useful data are missing")
expert_field("sis.body.unexpected", "PROTOCOL", "WARN", "More useful data than the service has")
expert_field("sis.body.note", "PROTOCOL", "NOTE", "Useful data that the documents do not define")
expert_field("sis.status.execution_error", "RESPONSE_CODE", "NOTE", "The status is an execution error")
expert_field("sis.status.telegram_error", "RESPONSE_CODE", "WARN", "The status is a telegram error")
expert_field("sis.start.missing", "MALFORMED", "ERROR", "No start character 0x02")
expert_field("sis.checksum.bad", "CHECKSUM", "ERROR", "Wrong checksum")
expert_field("sis.length.differ", "MALFORMED", "ERROR",
  "The two lengths differ: a bus does not answer this telegram, a point-to-point station answers with "
    .. "status 0xF2")
expert_field("sis.length.short", "MALFORMED", "ERROR", "The telegram is cut")
expert_field("sis.length.long", "PROTOCOL", "WARN", "Bytes follow the end of the telegram")
expert_field("sis.telegrams.many", "UNDECODED", "NOTE",
  "More telegrams in a packet than are decoded: only those that begin in its first 32,768 bytes")
expert_field("sis.length.header", "MALFORMED", "ERROR", "Subaddresses and telegram number do not fit into the length")
expert_field("sis.control.reserved.set", "PROTOCOL", "NOTE",
  "Reserved bits of the telegram control are set (another edition? preference sis.edition)")
expert_field("sis.control.status.set", "RESPONSE_CODE", "NOTE", "The status in the telegram control is not 'no error'")
expert_field("sis.control.status.error", "RESPONSE_CODE", "WARN", "The status in the telegram control is an error")
expert_field("sis.control.warning.set", "RESPONSE_CODE", "NOTE", "The sender signals a system warning")
expert_field("sis.control.error.set", "RESPONSE_CODE", "WARN", "The sender signals a system error")
expert_field("sis.service.reserved", "PROTOCOL", "NOTE", "Reserved service")
expert_field("sis.sender.service_master", "PROTOCOL", "NOTE",
  "Address 127, for service and emergencies only: not to be used while other masters communicate")
expert_field("sis.sender.invalid", "PROTOCOL", "WARN", "A sender address is not above 127")
expert_field("sis.receiver.reserved", "PROTOCOL", "WARN",
  "Receiver address that is not assigned or reserved (another edition? preference sis.edition)")
expert_field("sis.receiver.level_broadcast", "PROTOCOL", "WARN", "254 may only be the last address of the list")
expert_field("sis.reaction.unexpected", "PROTOCOL", "WARN", "A group or broadcast is not answered")
expert_field("sis.sequence.ended", "SEQUENCE", "NOTE", "A transfer of sequential telegrams ended unfinished")
expert_field("sis.sequence.piece_missing", "SEQUENCE", "NOTE",
  "A piece of this transfer may be missing: something that came between was damaged, lost or refused")
expert_field("sis.tza.exceeded", "PROTOCOL", "WARN", "TzA exceeded")
expert_field("sis.tza.unresolved", "PROTOCOL", "NOTE", "TzA perhaps exceeded")
expert_field("sis.trs.exceeded", "PROTOCOL", "WARN", "TrS exceeded")
expert_field("sis.trs.unresolved", "PROTOCOL", "NOTE", "TrS perhaps exceeded")
expert_field("sis.twm.early", "SEQUENCE", "NOTE", "Repeated before TrS was over")
expert_field("sis.tmas.exceeded", "PROTOCOL", "WARN", "Tmas exceeded")
expert_field("sis.tmas.unresolved", "PROTOCOL", "NOTE", "Tmas perhaps exceeded")
expert_field("sis.bus.baud.differs", "PROTOCOL", "NOTE", "The tap listens at another baud rate than the bus was told")

-- 3964r
field("3964r.character", "Character", ftypes.UINT8, base.HEX, N.procedure_characters, 0,
  "A single character of the procedure")
field("3964r.meaning", "Meaning", ftypes.UINT8, base.DEC, N.procedure_meanings, 0, "From what came before")
field("3964r.length", "Length of the data", ftypes.UINT32, base.DEC + base.UNIT_STRING, {" byte", " bytes"}, 0,
  "Without doubled DLEs")
field("3964r.doubled", "Doubled DLEs", ftypes.UINT32, base.DEC, nil, 0,
  "DLEs in the data that were sent twice, so that no data look like an end")
field("3964r.end", "End (DLE ETX)", ftypes.UINT16, base.HEX, nil, 0,
  "Marks the end of the block; the block check character follows")
field("3964r.bcc", "Block check character", ftypes.UINT8, base.HEX, nil, 0,
  "XOR of all bytes after STX, with doubled DLEs, DLE and ETX")
field("3964r.bcc.status", "Status of the block check character", ftypes.UINT8, base.NONE, N.checksum_states, 0,
  "Whether the block check character fits; unverified if bytes are missing")
field("3964r.data", "Data", ftypes.BYTES, base.NONE, nil, 0, "The data of the block, without doubled DLEs")
field("3964r.raw", "Not decoded", ftypes.BYTES, base.NONE, nil, 0, "Bytes that do not fit the procedure")
field("3964r.answers", "Answer to", ftypes.FRAMENUM, base.NONE, frametype.REQUEST, 0,
  "The packet that this character or block answers")
field("3964r.answer_in", "Answered in", ftypes.FRAMENUM, base.NONE, frametype.RESPONSE, 0,
  "The packet that answers this one")
field("3964r.answer_time", "Answered after", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "From the last character of what it answers")
field("3964r.try", "Try", ftypes.UINT32, base.DEC, nil, 0, "To connect, or to send this block")
field("3964r.repeat_of", "Repeat of", ftypes.FRAMENUM, base.NONE, frametype.RETRANS_PREV, 0,
  "The packet with the same block before")
field("3964r.unanswered_before", "Before, not answered", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet that got no answer before this one came")
field("3964r.qvz.limit", "QVZ (longest time to an answer)", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Acknowledgment delay: after it the partner tries again")
field("3964r.qvz.verdict", "Verdict on QVZ", ftypes.UINT8, base.DEC, N.procedure_verdicts, 0,
  "Whether the answer came in time, with the uncertainty of its time")
field("3964r.zvz.interval_max", "Longest interval", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Between two characters of the block")
field("3964r.zvz.position", "Longest interval before character", ftypes.UINT32, base.DEC, nil, 0,
  "Its number in the block, from 1")
field("3964r.zvz.limit", "ZVZ (longest interval allowed)", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "Character delay: after it the receiver gives the block up")
field("3964r.zvz.verdict", "Verdict on ZVZ", ftypes.UINT8, base.DEC, N.procedure_verdicts, 0,
  "Whether the intervals in the block keep ZVZ, with the uncertainty of their times")
expert_field("3964r.bcc.bad", "CHECKSUM", "ERROR", "Wrong block check character: the receiver answers NAK")
expert_field("3964r.broken", "MALFORMED", "WARN",
  "The block does not end with DLE ETX BCC, or a DLE in it is not doubled")
expert_field("3964r.conflict", "SEQUENCE", "NOTE", "Both partners ask at once: the one with low priority gives way")
expert_field("3964r.unexpected", "SEQUENCE", "NOTE", "There is nothing that this could answer")
expert_field("3964r.refused", "RESPONSE_CODE", "NOTE", "The partner refuses")
expert_field("3964r.repeat", "SEQUENCE", "NOTE", "The same block again")
expert_field("3964r.unanswered", "SEQUENCE", "NOTE", "Nobody answered what came before")
expert_field("3964r.tries", "SEQUENCE", "WARN", "More tries than 3964R has")
expert_field("3964r.exceeded", "PROTOCOL", "WARN", "A time of the procedure is exceeded")
expert_field("3964r.unresolved", "PROTOCOL", "NOTE", "A time of the procedure is perhaps exceeded")

-- rk512i
field("rk512i.follow_up", "Telegram", ftypes.UINT8, base.HEX, N.rk512_telegrams, 0,
  "The first telegram of a transfer, or one that continues it")
field("rk512i.zero", "Always 0", ftypes.UINT8, base.HEX, nil, 0, "The second byte of every telegram")
field("rk512i.command", "Command", ftypes.UINT8, base.HEX, N.rk512_commands, 0,
  "SEND writes to the partner, FETCH reads from it")
field("rk512i.kind", "Kind of data", ftypes.UINT8, base.HEX, N.rk512_kinds, 0,
  "What is accessed; SYNAX has data blocks only")
field("rk512i.block", "Data block", ftypes.UINT8, base.DEC, nil, 0, "Number of the data block in the PLC")
field("rk512i.block.word", "Word", ftypes.UINT16, base.HEX, nil, 0, "Of a data block")
field("rk512i.word", "Data word", ftypes.UINT8, base.DEC, nil, 0, "First word in the data block")
field("rk512i.count", "Count", ftypes.UINT16, base.DEC, nil, 0,
  "Words of data blocks, timers and counters, else bytes")
field("rk512i.flag_byte", "Byte of the coordination flag", ftypes.UINT8, base.HEX, nil, 0,
  "Byte of the PLC's flag that locks the block; FF: none")
field("rk512i.flag", "Bit and CPU of the coordination flag", ftypes.UINT8, base.HEX, nil, 0,
  "Bits 0 to 3: bit of the flag, bits 4 to 7: CPU; FF: none")
field("rk512i.error", "Error number", ftypes.UINT8, base.HEX, N.rk512_errors, 0,
  "Siemens' numbers; the table that SYNAX has is lost")
field("rk512i.data", "Data", ftypes.BYTES, base.NONE, nil, 0, "The data of this telegram")

-- arcnet7f
field("arcnet7f.id", "Protocol", ftypes.UINT8, base.HEX, nil, 0, "Always 0x7F")
field("arcnet7f.message", "Message number", ftypes.UINT16, base.HEX, nil, 0, "0x8010, in follow-ups 0x1c20 to 0x1cff")
field("arcnet7f.command", "Command", ftypes.UINT8, base.DEC, N.arcnet7f_commands, 0, "An answer is a TO")
field("arcnet7f.type", "Data type", ftypes.UINT8, base.DEC, N.arcnet7f_types, 0, "How the data are counted")
field("arcnet7f.length", "Length in words", ftypes.UINT16, base.DEC, nil, 0, "Of what follows it")
field("arcnet7f.block", "Data block", ftypes.UINT8, base.DEC, nil, 0, "Number of the data block")
field("arcnet7f.word", "Word", ftypes.UINT16, base.HEX, nil, 0, "Of a data block")
field("arcnet7f.list.actual", "Actual length of the list", ftypes.UINT16, base.DEC + base.UNIT_STRING,
  {" byte", " bytes"}, 0, "Bytes that the list has now")
field("arcnet7f.list.maximum", "Maximum length of the list", ftypes.UINT16, base.DEC + base.UNIT_STRING,
  {" byte", " bytes"}, 0, "Bytes that the list can have")
field("arcnet7f.first_in", "Follows the telegram in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet whose data this telegram continues")

-- synax
field("synax.request_in", "Request in", ftypes.FRAMENUM, base.NONE, frametype.REQUEST, 0,
  "The packet that this answer belongs to")
field("synax.answer_in", "Answer in", ftypes.FRAMENUM, base.NONE, frametype.RESPONSE, 0,
  "The packet that answers this request")
field("synax.answer_time", "Time to the answer", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "From the request to its answer")
field("synax.next_request_in", "Next request in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "Where nobody read an answer before it")
field("synax.unanswered_in", "Request before, not answered", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet with the request that got no answer")
field("synax.info", "Info access", ftypes.UINT16, base.HEX, nil, 0,
  "Read or write, and whether more follows; the other bits are not defined")
field("synax.info.open", "Not defined", ftypes.UINT16, base.HEX, nil, 0xfffc, "Bits that no document explains")
field("synax.info.last", "Last transmission", ftypes.BOOLEAN, 16, nil, 0x02, "Whether this is the last transmission")
field("synax.info.write", "Write", ftypes.BOOLEAN, 16, nil, 0x01, "Set: write. Not set: read")
field("synax.axis", "Axis", ftypes.UINT8, base.DEC, nil, 0, "Drive, 0: none; with a data block its number")
field("synax.pieces", "Pieces", ftypes.NONE, base.NONE, nil, 0, "The telegrams that carry the pieces of these data")
field("synax.pieces.piece", "Piece", ftypes.FRAMENUM, base.NONE, nil, 0, "The packet with this piece")
field("synax.pieces.overlap", "Overlap", ftypes.BOOLEAN, base.NONE, nil, 0, "This piece repeats bytes of another")
field("synax.pieces.overlap.conflict", "Overlap with other data", ftypes.BOOLEAN, base.NONE, nil, 0,
  "This piece repeats bytes of another with other contents")
field("synax.pieces.multiple_tails", "Several last pieces", ftypes.BOOLEAN, base.NONE, nil, 0,
  "More than one piece says that it is the last")
field("synax.pieces.too_long", "Piece too long", ftypes.BOOLEAN, base.NONE, nil, 0,
  "This piece goes beyond the end of the data")
field("synax.pieces.error", "Error while putting together", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet in which the pieces did not fit")
field("synax.pieces.count", "Number of pieces", ftypes.UINT32, base.DEC, nil, 0, "How many telegrams carry these data")
field("synax.pieces.whole_in", "The whole is in", ftypes.FRAMENUM, base.NONE, nil, 0,
  "The packet that shows the joined data")
field("synax.pieces.length", "Length of the whole", ftypes.UINT32, base.DEC + base.UNIT_STRING, {" byte", " bytes"}, 0,
  "Bytes of the joined data")
expert_field("synax.note", "PROTOCOL", "NOTE", "Content that the documents do not define")
expert_field("synax.short", "PROTOCOL", "WARN", "Bytes are missing")
expert_field("synax.unexpected", "PROTOCOL", "WARN", "More bytes than expected")
expert_field("synax.error", "RESPONSE_CODE", "NOTE", "The answer reports an error")
expert_field("synax.failed", "RESPONSE_CODE", "WARN", "The fieldbus has failed")
expert_field("synax.unanswered", "SEQUENCE", "NOTE", "No answer before the next request")
expert_field("synax.unanswered_before", "SEQUENCE", "NOTE", "A request before this one got no answer")
expert_field("synax.pieces.too_many", "SEQUENCE", "NOTE", "More than 8192 pieces: they are not joined")

-- synaxpk
field("synaxpk.word", "Control or status word", ftypes.UINT16, base.HEX, nil, 0,
  "FBSteuer of the master, FBStatus of the slave")
field("synaxpk.word.open", "Not defined", ftypes.UINT16, base.HEX, nil, 0xc000,
  "Bits that no document explains. In the short format 3 the bit Control 1 is always set: its place "
    .. "is not known (SYNAX p. 3-20)")
field("synaxpk.word.error", "Error", ftypes.BOOLEAN, 16, nil, 0x2000, "Of the slave; of the master: clear the error")
field("synaxpk.word.read", "Access to the channel", ftypes.BOOLEAN, 16, {"Read", "Write"}, 0x1000,
  "An order is written and its answer read, that of writing a parameter, too")
field("synaxpk.word.busy", "Bit 11 (busy)", ftypes.BOOLEAN, 16, nil, 0x800, "Not certain")
field("synaxpk.word.last", "Last fragment", ftypes.BOOLEAN, 16, nil, 0x400,
  "Whether this is the last fragment of the telegram")
field("synaxpk.word.bit9", "Bit 9 (handshake)", ftypes.BOOLEAN, 16, nil, 0x200, "Not certain")
field("synaxpk.word.toggle", "Toggle", ftypes.BOOLEAN, 16, nil, 0x100,
  "The master changes it each cycle, and the slave copies it")
field("synaxpk.word.count", "Valid data bytes", ftypes.UINT16, base.DEC, nil, 0xf0,
  "How many bytes after the word count")
field("synaxpk.word.format", "Format", ftypes.UINT16, base.HEX, N.channel_formats, 0x0f,
  "The layout of the data after the word")
field("synaxpk.sender", "Sender", ftypes.UINT8, base.DEC, N.channel_senders, 0, "Who has sent this word")
field("synaxpk.payload", "Data of this packet", ftypes.BYTES, base.NONE, nil, 0, "The valid bytes after the word")
field("synaxpk.beyond", "Not valid", ftypes.BYTES, base.NONE, nil, 0, "Bytes of the channel after the valid ones")
field("synaxpk.byte", "Byte", ftypes.UINT8, base.HEX, nil, 0, "Not defined")
field("synaxpk.class", "Error class", ftypes.UINT8, base.HEX, nil, 0, "High byte of the error code")
field("synaxpk.class.code", "Error code in its class", ftypes.UINT8, base.HEX, nil, 0, "Low byte of the error code")
field("synaxpk.code", "Error of the channel", ftypes.UINT16, base.HEX + base.RANGE_STRING, N.channel_codes, 0,
  "Why the channel refuses the request")
field("synaxpk.sis.length", "Length (DatL)", ftypes.UINT8, base.DEC, nil, 0,
  "Bytes of useful data of the SIS telegram")
field("synaxpk.sis.length_repeated", "Length again (DatLW)", ftypes.UINT8, base.DEC, nil, 0, "Must equal the length")
field("synaxpk.sis.control", "Telegram control (Cntrl)", ftypes.UINT8, base.HEX, nil, 0,
  "Direction of the SIS telegram")
field("synaxpk.sis.service", "Service", ftypes.UINT8, base.HEX, nil, 0, "SIS service in the channel")
field("synaxpk.drive", "Control or status word", ftypes.UINT16, base.HEX, nil, 0, "Of IndraDrive")
field("synaxpk.drive.pf", "Ident of 4 bytes (PF)", ftypes.BOOLEAN, 16, nil, 0x8000,
  "Set: idents have 4 bytes. Not set: 2 bytes")
field("synaxpk.drive.error", "G; in a status word F, error", ftypes.BOOLEAN, 16, nil, 0x4000,
  "In a status word: the data are an error")
field("synaxpk.drive.last", "Last fragment (L)", ftypes.BOOLEAN, 16, nil, 0x2000, "Whether this is the last fragment")
field("synaxpk.drive.toggle", "Toggle (T)", ftypes.BOOLEAN, 16, nil, 0x1000, "Marks a new fragment")
field("synaxpk.drive.fragment", "Bytes in this fragment (FL)", ftypes.UINT16, base.DEC, nil, 0xf00,
  "How many bytes of data this packet carries")
field("synaxpk.drive.length", "Bytes left, with this fragment (GL)", ftypes.UINT16, base.DEC, nil, 0xff,
  "How many bytes are still to come, these included")
field("synaxpk.index", "Index", ftypes.UINT16, base.HEX, nil, 0, "0x2000 and the ident number of a parameter")
field("synaxpk.subindex", "Subindex", ftypes.UINT16, base.DEC, nil, 0, "Element of the parameter; 7: operating data")

-- synaxobj
field("synaxobj.index", "Object", ftypes.UINT16, base.HEX, N.synaxobj_names, 0, "Which object is read or written")
field("synaxobj.operation", "Operation", ftypes.UINT8, base.DEC, N.synaxobj_operations, 0,
  "Read or write, request or answer")
field("synaxobj.raw", "Raw", ftypes.BYTES, base.NONE, nil, 0, "Bytes that are not decoded")
field("synaxobj.padding", "Padding", ftypes.BYTES, base.NONE, nil, 0, "What fills the object up after its telegram")
field("synaxobj.open_bit", "Bit that is set and not defined", ftypes.UINT8, base.DEC, nil, 0,
  "Number of a bit that no document explains")
field("synaxobj.diagnosis", "Diagnosis fieldbus", ftypes.UINT16, base.HEX, nil, 0,
  "Fault code and interface of the fieldbus card")
field("synaxobj.diagnosis.interface", "Interface", ftypes.UINT16, base.DEC, nil, 0xf000,
  "Which is which is not defined")
field("synaxobj.diagnosis.fault", "Fault code", ftypes.UINT16, base.HEX, nil, 0xff,
  "Of the fieldbus, each has its own")
field("synaxobj.status", "Status fieldbus", ftypes.UINT16, base.HEX, nil, 0, "State of the fieldbus card")
field("synaxobj.status.bus", "Bus", ftypes.BOOLEAN, 16, {"No failure", "After a failure of the bus"}, 0x08,
  "Whether the fieldbus has failed")
field("synaxobj.status.memory", "State of the dual-port RAM", ftypes.UINT16, base.DEC, nil, 0x03,
  "Which is which is not defined")
field("synaxobj.ppc", "Word of the PPC", ftypes.UINT16, base.HEX, nil, 0,
  "Written by the PPC; no document explains it")
field("synaxobj.fault", "Fault code PPC", ftypes.UINT16, base.HEX, nil, 0, "The next valid access clears it")
field("synaxobj.fault.communication", "Communication channel", ftypes.UINT16, base.HEX, nil, 0xff00,
  "Fault code of the communication channel")
field("synaxobj.fault.process_data", "Process data channel", ftypes.UINT16, base.HEX, nil, 0xff,
  "Fault code of the process data channel")

-- synaxpcp
field("synaxpcp.service", "Service", ftypes.UINT16, base.HEX, N.synaxpcp_services, 0,
  "What the telegram asks for or answers")
field("synaxpcp.count", "Word count", ftypes.UINT16, base.DEC, nil, 0, "Words after this one")
field("synaxpcp.invoke", "Invoke id", ftypes.UINT8, base.DEC, nil, 0,
  "Tells requests apart that wait at the same time")
field("synaxpcp.reference", "Communication reference", ftypes.UINT8, base.DEC, nil, 0, "Which device")
field("synaxpcp.index", "Index", ftypes.UINT16, base.HEX, nil, 0, "Which object")
field("synaxpcp.index_of_request", "Index of the request", ftypes.UINT16, base.HEX, nil, 0,
  "An answer does not name its object")
field("synaxpcp.subindex", "Subindex", ftypes.UINT8, base.DEC, nil, 0, "Which element of it, 0: the whole")
field("synaxpcp.length", "Length", ftypes.UINT8, base.DEC, nil, 0, "Bytes of data")
field("synaxpcp.data", "Data", ftypes.BYTES, base.NONE, nil, 0, "What is read or written")
field("synaxpcp.padding", "Padding", ftypes.BYTES, base.NONE, nil, 0, "What fills up a word")
field("synaxpcp.result", "Result", ftypes.UINT16, base.HEX, nil, 0, "0: done")
field("synaxpcp.error", "Error", ftypes.UINT32, base.HEX, nil, 0,
  "Error class, error code and additional code as one number")
field("synaxpcp.error.class", "Error class", ftypes.UINT8, base.DEC, nil, 0, "Kind of the error")
field("synaxpcp.error.code", "Error code", ftypes.UINT8, base.DEC, nil, 0, "The error in its class")
field("synaxpcp.error.additional", "Additional code", ftypes.UINT16, base.HEX, nil, 0,
  "More about the error; the device defines it")
field("synaxpcp.raw", "Raw", ftypes.BYTES, base.NONE, nil, 0, "Bytes that are not decoded")
field("synaxpcp.request_in", "Request in", ftypes.FRAMENUM, base.NONE, frametype.REQUEST, 0,
  "The packet that this response answers")
field("synaxpcp.response_in", "Response in", ftypes.FRAMENUM, base.NONE, frametype.RESPONSE, 0,
  "The packet that answers this request")
field("synaxpcp.response_time", "Time to the response", ftypes.RELATIVE_TIME, base.NONE, nil, 0,
  "From the request to its response")

-- synaxpd
field("synaxpd.direction", "Direction", ftypes.UINT8, base.DEC, N.synaxpd_directions, 0,
  "Known where one port is among those of preference synaxpd.ports")
field("synaxpd.word", "Word", ftypes.UINT16, base.HEX, nil, 0,
  "A word of process data; parameters of the PPC define what it means")
field("synaxpd.value", "Value", ftypes.STRING, base.NONE, nil, 0, "As the table of process data names it")
field("synaxpd.raw", "Raw", ftypes.BYTES, base.NONE, nil, 0, "Bytes that are no word")

-- sisascii
field("sisascii.kind", "Line", ftypes.UINT8, base.DEC, N.ascii_kinds, 0, "What a line of the ASCII protocol is")
field("sisascii.drive", "Drive", ftypes.UINT8, base.DEC, nil, 0,
  "Address of the drive that is opened, or that shows its prompt; of other lines: of the drive that is open")
field("sisascii.element", "Element", ftypes.UINT8, base.DEC, N.elements, 0,
  "Which part of a parameter is read or written")
field("sisascii.index", "Number in the list", ftypes.UINT32, base.DEC, nil, 0,
  "Which element of a list this is, from 1")
field("sisascii.text", "Text", ftypes.STRING, base.NONE, nil, 0, "The characters of a line that is no command")
-- end of fields

do
  K.IF02, K.ECODRIVE03 = 0, 1 -- preference sis.edition: addresses, names of services, bits of the telegram control

  local FIRST_RESERVED_IN_ECODRIVE03 = 0xE0 -- DISC in IF02
  local RESERVED = "Reserved service"
  local names = {[K.IF02] = {}, [K.ECODRIVE03] = {}} -- of all 256 services: every telegram needs it
  local range_names = {[K.IF02] = {}, [K.ECODRIVE03] = {}}

  for service = 0, 255 do
    local text, range = range_text(service, N.services)

    range_names[K.IF02][service] = text
    names[K.IF02][service] = range[1] == range[2] and text or strformat("%s 0x%02x", text, service)
    local is_reserved = service >= FIRST_RESERVED_IN_ECODRIVE03
    range_names[K.ECODRIVE03][service] = is_reserved and RESERVED or text
    names[K.ECODRIVE03][service] = is_reserved and strformat("%s 0x%02x", RESERVED, service) or names[K.IF02][service]
  end

  -- "Read parameter", or "ECODRIVE service" where only the range has a name.
  function S.service_range_name(service)
    return range_names[P.edition][service]
  end

  -- "Read parameter", or "ECODRIVE service 0x83" where only the range has a name.
  function S.service_name(service)
    return names[P.edition][service]
  end

  -- In the edition that is set.
  function S.service_is_reserved(service)
    return range_names[P.edition][service] == RESERVED
  end
end

--- sertap/time: times as numbers with an end, and as text that is the same in every locale.

do
  local LATEST = 9.15e18 -- ns, 290 years: a capture may claim any time

  -- How long it is from one time to another, in ns, up to LATEST either way.
  function T.elapsed(from, to)
    return max(min(to - from, LATEST), -LATEST)
  end

  -- `value` / `divisor`, rounded, in units of the last decimal: 12345678 / 1000 with 3 decimals is "12.346". Made from
  -- integers: %f would write a comma where the user's locale has one, and people compare and filter for these texts.
  function T.decimal_text(value, divisor, decimals)
    local magnitude, unit = math.abs(value), 10 ^ decimals
    local rest = fmod(magnitude, divisor)
    local digits = (magnitude - rest) / divisor + (rest > 0 and rest >= divisor / 2 and 1 or 0)
    local fraction = fmod(digits, unit)

    return strformat("%s%.0f.%0" .. decimals .. "d", value < 0 and "-" or "", (digits - fraction) / unit, fraction)
  end

  function T.ms_text(ns, is_longer)
    return (is_longer and "more than " or "") .. T.decimal_text(ns, 1e3, 3) .. " ms"
  end
end

--- sertap/line: what is known of a line, record after record, in the first pass

do
  local WINDOW_NS = 1e9 -- the load is averaged over this time
  K.LONGEST_INTERVAL = 0xFFFFFFFF -- ns that a record can hold
  local SHORTEST_FRAME = 8 -- fewer other characters are what a line says when its direction turns

  local lines -- by key
  local window_of, last_of -- by frame: of its line, and its last busy time then
  local silence_of -- by frame, ns: of records whose first interval is longer than it can be stored

  at_init(function() lines, window_of, last_of, silence_of = {}, {}, {}, {} end)

  -- Spells have numbers from 1. Each has its beginning and end in ns, the busy time of the line up to its end, and
  -- the first busy time in the window then.
  local function new_window(has_restarted)
    return {last = 0, head = 1, begins = {}, ends = {}, totals = {[0] = 0}, heads = {}, has_restarted = has_restarted}
  end

  local function note_disturbance(line, record)
    local is_gap = record.type == K.SERTAP_EVENT
      and (record.event == K.SERTAP_CHARACTERS_LOST or record.event == K.SERTAP_ADAPTER_LOST)

    if is_gap or band(record.flags, K.SERTAP_ERROR_LOST) ~= 0 then line.lost_in = packet.number end
    if record.type == K.SERTAP_EVENT and record.event == K.SERTAP_CAPTURE_STARTED then line.begun_in = packet.number end
    if record.type == K.SERTAP_OTHER and record.count >= SHORTEST_FRAME then line.unframed_in = packet.number end
  end

  local function note_busy(line, record)
    local character = record.character_ns
    local busy = character * record.count
    local duration = record.duration
    local finish = packet.time + duration

    if busy == 0 then return end
    -- If the clock went back, what was busy earlier says nothing.
    if finish < (line.window.ends[line.window.last] or finish) then line.window = new_window(true) end
    local window = line.window
    local last, head, ends = window.last + 1, window.head, window.ends

    ends[last] = finish
    window.begins[last] = finish - max(busy, duration + character)
    window.totals[last] = window.totals[last - 1] + busy
    while head < last and ends[head] <= finish - WINDOW_NS do
      head = head + 1
    end
    window.heads[last] = head
    window.last, window.head = last, head
  end

  -- The interval before the first character.
  local function is_saturated(record)
    return T.interval_of(record, 0) == K.LONGEST_INTERVAL
      or band(T.flags_of(record, 0), K.SERTAP_INTERVAL_SATURATED) ~= 0
  end

  -- A longer time than can be stored, or the clock has changed.
  local function note_silence(line, record)
    if not is_saturated(record) or not line.last_time or line.last_line ~= record.line then return end
    local elapsed = T.elapsed(line.last_time, packet.time)

    if elapsed >= K.LONGEST_INTERVAL then silence_of[packet.number] = elapsed end
  end

  -- ns before the first character of a record, since the one before it on the line, and whether it was longer.
  function T.silence(record)
    if not is_saturated(record) then return T.interval_of(record, 0), false end
    local silence = silence_of[packet.number]

    return silence or T.interval_of(record, 0), not silence
  end

  -- First pass: takes a record into account. record.known is its line: the packets that may hide a frame (lost_in:
  -- the last loss of characters, unframed_in: the last that may have been a frame, begun_in: the last event that says
  -- that a capture begins; 0 if there is none), and the limits that the user told of it: {told_in: the event, text};
  -- nil: none.
  function T.line_note(record)
    local key, number = S.line_key(S.place()), packet.number
    local line = lines[key] or {lost_in = 0, unframed_in = 0, begun_in = 0, window = new_window(false)}

    lines[key], record.known = line, line
    if record.type == K.SERTAP_BEFORE then return end
    if record.flags ~= 0 or record.type ~= K.SERTAP_FRAME then note_disturbance(line, record) end
    if record.type ~= K.SERTAP_EVENT then note_busy(line, record) end
    if record.type ~= K.SERTAP_EVENT and record.count > 0 then
      if record.timed > 0 then note_silence(line, record) end
      local is_known = record.timed == record.count and not record.is_longer

      line.last_time = is_known and packet.time + record.duration or nil
      line.last_line = record.line
    end
    if record.type == K.SERTAP_EVENT and record.event == K.SERTAP_LIMITS_TOLD and record.values == record.declared then
      -- Of a text that is cut, the beginning of a number is another number.
      local text = sub(record.bytes, record.data_offset + 1, record.data_offset + record.values)

      line.limits = {told_in = number, text = string.match(text, "^[^\0]*")}
    end
    window_of[number], last_of[number] = line.window, line.window.last
  end

  -- How long the line was busy until this packet, and during what time, both in ns; nothing if unknown. The window
  -- may cut the oldest of them.
  function T.load()
    local window, last = window_of[packet.number], last_of[packet.number]
    local head = window and window.heads[last]

    if not head then return end
    local totals, first, finish = window.totals, window.begins[head], window.ends[last]
    local busy, begin = totals[last] - totals[head - 1], max(finish - WINDOW_NS, window.begins[1])

    if finish <= begin or (window.has_restarted and finish - begin < WINDOW_NS) then return end
    if first < begin then
      busy = busy - floor((totals[head] - totals[head - 1]) * (begin - first) / (window.ends[head] - first))
    end
    return busy, finish - begin
  end

  -- The double nearest to x that fits into C's float, in which the plugin keeps the load.
  local function single(x)
    local scaled = x * 536870913.0 -- 2^29 + 1

    return scaled - (scaled - x)
  end

  -- The result of T.load(), in percent.
  function T.percent(busy, span)
    return single(min(max(single(single(busy) / single(span)), 0), 1) * 100)
  end
end

--- sertap/packet-sertap: one record a packet, with value, interval and flags of every character

do
  local RECORD_VERSION, RECORD_HEADER_SIZE = 1, 20
  local FRAMING_SIS, FRAMING_3964R = 0, 1
  local UNCERTAINTY_UNKNOWN = 0xFFFFFFFF


  local parity_letters = {[0] = "N", [1] = "E", [2] = "O", [3] = "M", [4] = "S"}

  -- The name of a flag at its character, and, for an error, the text about its record, with the number of the first
  -- such character.
  local flags = {
    {flag = K.SERTAP_SAME_READ, field = FT.same_read, text = "same read"},
    {flag = K.SERTAP_ERROR_CHARACTER, field = FT.error_character, text = "parity or framing error",
      expert = ET.error_character_expert, mark = "parity or framing error at character %d"},
    {flag = K.SERTAP_ERROR_BREAK, field = FT.error_break, text = "break", expert = ET.error_break_expert,
      mark = "break at character %d"},
    {flag = K.SERTAP_ERROR_LOST, field = FT.error_lost, text = "characters lost before it",
      expert = ET.error_lost_expert,
      mark = "the tap lost characters before character %d"},
    {flag = K.SERTAP_ERROR_UNLOCATED, field = FT.error_unlocated, text = "error somewhere in this read",
      expert = ET.error_unlocated_expert, mark = "line error, place unknown"},
    {flag = K.SERTAP_INTERVAL_UNKNOWN, field = FT.interval_unknown, text = "interval unknown"},
    {flag = K.SERTAP_INTERVAL_SATURATED, field = FT.interval_saturated, text = "interval longer than it can be stored"},
  }

  local framing_table = DissectorTable.new("sertap.framing", "Serial framing", ftypes.UINT8, base.DEC, sertap)
  local handle -- of this dissector, once there is one

  -- How long a packet is, or the payload of a record, with what the capture has cut. For Lua, a part of a packet ends
  -- where the capture has cut it.
  function T.reported_len(tvb)
    local record = packet.record

    if record and record.values < record.count and T.index(record, tvb) == 0 then return record.count end
    return reported_len(tvb)
  end

  -- The index, from 0, of the first character of the record in `part`, a subset of its payload.
  function T.index(record, part)
    return part:offset() - (record.has_own_source and 0 or record.tvb:offset() + record.data_offset)
  end

  local interval_formats = {}

  for count = 0, CHUNK do
    interval_formats[count] = ">" .. rep("I4", count)
  end

  local function read_intervals(bytes, offset, count)
    local intervals = {}

    for done = 0, count - 1, CHUNK do
      local size = min(count - done, CHUNK)
      local some = {Struct.unpack(interval_formats[size], bytes, offset + 4 * done + 1)}

      for i = 1, size do
        intervals[done + i] = some[i]
      end
    end
    return intervals
  end

  -- Their sum, which every record needs, without a table.
  local function sum_intervals(bytes, offset, count)
    local sum = 0

    for done = 0, count - 1, CHUNK do
      local size, at = min(count - done, CHUNK), offset + 4 * done + 1
      local after = at + 4 * size -- the last result of unpack()

      sum = total(sum - after, Struct.unpack(interval_formats[size], bytes, at))
    end
    return sum
  end

  -- ns since the character before, of each.
  function T.intervals(record)
    record.intervals = record.intervals or read_intervals(record.bytes, record.times_offset, record.timed)
    return record.intervals
  end

  -- The same of one character, without a table; they count from 0.
  function T.interval_of(record, character)
    local at = record.times_offset + 4 * character + 1
    local a, b, c, d = byte(record.bytes, at, at + 3)

    return ((a * 256 + b) * 256 + c) * 256 + d
  end

  -- ns from the first character to another. The requests for a packet come in order: each goes on from the last.
  function T.since_first(record, character)
    local intervals = T.intervals(record)

    if character < record.reached then record.reached, record.reached_ns = 0, 0 end
    for i = record.reached + 1, character do
      record.reached_ns = record.reached_ns + intervals[i + 1]
    end
    record.reached = character
    return record.reached_ns
  end

  function T.flags_of(record, character)
    return record.flags == 0 and 0 or byte(record.bytes, record.flags_offset + character + 1)
  end

  local function write_columns(pinfo, info)
    local cols = pinfo.cols

    cols.protocol = "SERTAP"
    cols.info = info
  end

  -- "8E1" and its parts.
  local function add_format(tree, tvb, record)
    local parity, stop = parity_letters[record.parity] or "?", N.sertap_stop_bits[record.stop_half_bits] or "?"
    local subtree = add(tree, FT.format, tvb, 8, 3, strformat("%d%s%s", record.data_bits, parity, stop)) or tree

    add(subtree, FT.format_data_bits, tvb, 8, 1)
    add(subtree, FT.format_parity, tvb, 9, 1)
    add(subtree, FT.format_stop, tvb, 10, 1)
  end

  -- Unknown has no value: otherwise a filter for bad times would find it.
  local function add_uncertainty(tree, tvb, uncertainty)
    if uncertainty then
      add_duration(tree, FT.uncertainty, tvb, 12, 4, uncertainty, T.ms_text, uncertainty)
    else
      add_subtree(tree, tvb, 12, 4, "Uncertainty of the times: unknown")
    end
  end

  local function show_header(tvb, tree, record)
    add(tree, FT.type, tvb, 2, 1)
    add(tree, FT.line, tvb, 3, 1)
    local item = add(tree, FT.baud, tvb, 4, 4)
    if record.baud == 0 then append_text(item, " (unknown)") end
    add_format(tree, tvb, record)
    add(tree, FT.framing, tvb, 11, 1)
    add_uncertainty(tree, tvb, record.uncertainty)
  end

  -- Whether version and length of the header are valid; if not, says why. The second result tells whether the capture
  -- has cut the packet.
  local function check_header(tvb, tree, root, bytes, there)
    local version, size = byte(bytes, 1, 2)

    if not version then
      if there == 0 then add_expert(root, ET.truncated) end
      return false, there > 0
    end
    local item = add(tree, FT.version, tvb, 0, 1) or root
    if version ~= RECORD_VERSION then
      add_expert(item, ET.version_unknown)
      return false
    end
    if there < RECORD_HEADER_SIZE then
      add_expert(item, ET.truncated)
      return false
    end
    if not size then return false, true end
    item = add(tree, FT.header_length, tvb, 1, 1) or root
    if size < RECORD_HEADER_SIZE or there < size then
      add_expert(item, size < RECORD_HEADER_SIZE and ET.header_length_short or ET.truncated)
      return false
    end
    return #bytes >= size, #bytes < size
  end

  -- ns of one character, including start and stop bits; 0 if the rate is unknown.
  local function character_ns(record)
    local half_bits = 2 + 2 * record.data_bits + (record.parity ~= 0 and 2 or 0) + record.stop_half_bits

    return record.baud ~= 0 and floor(half_bits * 500000000 / record.baud) or 0
  end

  -- A capture has few different headers. Records with the same header share one table, because making tables would
  -- take most of the time. It holds the header, and what read_record() adds.
  local record_of = remembered(1000, function(header)
    local record, version, size, uncertainty, declared = {}
    version, size, record.type, record.line, record.baud, record.data_bits, record.parity, record.stop_half_bits,
      record.framing, uncertainty, declared, record.event = Struct.unpack(">BBBBI4BBBBI4I2I2", header)

    record.uncertainty = uncertainty ~= UNCERTAINTY_UNKNOWN and uncertainty or nil -- ns
    record.declared = declared -- characters according to the record
    record.data_offset = size -- of the values
    record.times_offset = size + declared -- of the intervals, 4 bytes each, ns
    record.flags_offset = size + declared * 5
    record.character_ns = character_ns(record)
    record.expected = declared * (record.type == K.SERTAP_EVENT and 1 or 6) -- bytes after the header
    record.is_readable = version == RECORD_VERSION and size >= RECORD_HEADER_SIZE
    record.size = nil -- of the packet
    record.captured = nil -- how much of it the capture has: what follows belongs to this size and this much
    record.count = nil -- characters of the record
    record.values = nil -- characters whose value is here
    record.timed = nil -- characters whose interval and flags are here as well
    record.no_flags = nil -- their values without characters
    return record
  end)

  -- Decodes whatever is complete. The three arrays follow one another: missing bytes at the end are first missing
  -- from the flags.
  local function count_characters(record, captured, size)
    local declared, rest = record.declared, max(captured - record.data_offset, 0)

    record.size, record.captured = size, captured
    record.count = min(size - record.data_offset, declared)
    record.values = min(rest, declared)
    record.timed = record.type ~= K.SERTAP_EVENT and max(min(rest - declared * 5, declared), 0) or 0
    record.no_flags = rep("\0", record.timed)
  end

  -- Reads a record with a valid header.
  local function read_record(record, tvb, bytes, there)
    if record.captured ~= #bytes or record.size ~= there then count_characters(record, #bytes, there) end
    record.tvb = tvb
    record.bytes = bytes
    record.known = nil -- in the first pass: the state of the line
    record.flags = 0 -- of all its characters, ORed
    record.first_at = nil -- by flag: the first character that has it
    record.intervals = nil -- ns, if requested
    record.longest, record.longest_at = nil, nil -- of them, if requested
    record.reached, record.reached_ns = 0, 0 -- the last character whose time was requested
    record.duration = 0 -- ns, from the first character to the last
    record.is_longer = false -- it took more than that
  end

  -- Compares the count with the bytes of the record.
  local function check_count(item, record, there)
    local rest, expected = there - record.data_offset, record.expected

    if rest < expected then
      add_expert(item, ET.truncated)
    elseif rest > expected then
      add_expert(item, ET.count_wrong)
    end
  end

  -- The flags of all characters together, and the first character with each of them.
  local function survey_flags(record)
    local bytes, offset = record.bytes, record.flags_offset
    local at = string.find(bytes, "[^\0]", offset + 1)

    record.first_at = {}
    while at and at <= offset + record.timed do
      local flag = byte(bytes, at)

      for bit_value = 0, 7 do
        local one = lshift(1, bit_value)

        if band(flag, one) ~= 0 and not record.first_at[one] then record.first_at[one] = at - offset - 1 end
      end
      if at > offset + 1 and band(flag, K.SERTAP_INTERVAL_SATURATED) ~= 0 then record.is_longer = true end
      record.flags = bit.bor(record.flags, flag)
      at = string.find(bytes, "[^\0]", at + 1)
    end
  end

  -- How long it took, and errors.
  local function survey_characters(record)
    local bytes, flags_at, timed = record.bytes, record.flags_offset + 1, record.timed

    if sub(bytes, flags_at, flags_at + timed - 1) ~= record.no_flags then survey_flags(record) end
    record.duration = sum_intervals(bytes, record.times_offset + 4, timed - 1)
  end

  -- The longest interval, and the character after it; 0 if there is none. The interval before the first character
  -- does not belong to this record. The interval before a character that follows lost ones is unknown.
  function T.longest(record)
    if record.longest then return record.longest, record.longest_at end
    local may_be_lost = band(record.flags, K.SERTAP_ERROR_LOST) ~= 0
    local longest, longest_at, intervals = 0, 0, T.intervals(record)

    for character = 1, record.timed - 1 do
      local interval = intervals[character + 1]

      if interval > longest and not (may_be_lost and band(T.flags_of(record, character), K.SERTAP_ERROR_LOST) ~= 0) then
        longest, longest_at = interval, character
      end
    end
    record.longest, record.longest_at = longest, longest_at
    return longest, longest_at
  end

  -- A character says nothing if it has no flag and came about as long after the one before it as it takes itself: then
  -- it is there for filters, and hidden. Returns whether it is.
  local function add_character(tree, tvb, record, index)
    local data_at, time_at = record.data_offset + index, record.times_offset + 4 * index
    local flags_at, usual = record.flags_offset + index, record.character_ns
    local value, flag = byte(record.bytes, data_at + 1), T.flags_of(record, index)
    local interval, is_longer = T.interval_of(record, index), band(flag, K.SERTAP_INTERVAL_SATURATED) ~= 0
    local is_usual = index > 0 and flag == 0 and 2 * math.abs(interval - usual) < usual
    local item = not unwanted[FT.character] and add(tree, FT.character, tvb, data_at, 1, value,
      not is_usual and strformat("Character %d: 0x%02x", index + 1, value) or nil)
    local subtree = item or tree

    if index == 0 then interval, is_longer = T.silence(record) end
    if is_usual then
      set_hidden(item)
      if not unwanted[FT.interval] then add(subtree, FT.interval, tvb, time_at, 4, nstime(interval)) end
    elseif band(flag, K.SERTAP_INTERVAL_UNKNOWN) == 0 then
      local text = item and T.ms_text(interval, is_longer) or ""

      append_text(item, ", after " .. text)
      add_duration(subtree, FT.interval, tvb, time_at, 4, interval, text)
    end
    add(subtree, FT.flags, tvb, flags_at, 1)
    if flag == 0 then return is_usual end -- most of them
    for _, known in ipairs(flags) do
      if band(flag, known.flag) ~= 0 then
        append_text(item, ", " .. known.text)
        add(subtree, known.field, tvb, flags_at, 1)
      end
    end
    return false
  end

  local function interval_max_text(record, longest, at)
    local text = T.ms_text(longest, band(T.flags_of(record, at), K.SERTAP_INTERVAL_SATURATED) ~= 0)

    return strformat("%s, before character %d%s", text, at + 1,
      record.uncertainty and strformat(" (times uncertain by %s)", T.ms_text(record.uncertainty)) or "")
  end

  local function add_interval_max(tree, tvb, record)
    if unwanted[FT.interval_max] then return end
    local longest, at = T.longest(record)

    if at > 0 then
      set_generated(add_duration(tree, FT.interval_max, tvb, record.times_offset + 4 * at, 4, longest,
        interval_max_text, record, longest, at))
    end
  end

  -- Whether the characters are displayed or filtered. Usually a large file needs neither, and a record has five items
  -- for each character.
  local function are_characters_wanted(tree, record)
    if is_wanted(tree, FT.character) or is_wanted(tree, FT.interval) or is_wanted(tree, FT.flags) then return true end
    for _, known in ipairs(record.flags ~= 0 and flags or {}) do
      if is_wanted(tree, known.field) then return true end
    end
    return false
  end

  local function add_characters(tree, tvb, record)
    local length, usual = record.flags_offset + record.timed - record.data_offset, 0

    add_interval_max(tree, tvb, record)
    if not are_characters_wanted(tree, record) then return end
    local subtree = add_subtree(tree, tvb, record.data_offset, length,
      strformat("%d character%s", record.timed, plural(record.timed)))
    local intervals, are_enough = T.intervals(record), unwanted[FT.character] and unwanted[FT.flags]
    for index = 0, record.timed - 1 do
      if are_enough and index > 0 and T.flags_of(record, index) == 0 then
        add(subtree, FT.interval, tvb, record.times_offset + 4 * index, 4, nstime(intervals[index + 1]))
      elseif add_character(subtree, tvb, record, index) then
        usual = usual + 1
      end
    end
    if usual > 0 and are_texts_read then
      append_text(subtree, strformat(", %d of %d intervals of about one character (%s)", usual, record.timed - 1,
        T.ms_text(record.character_ns)))
    end
  end

  -- One item and one mark for each kind of error, however many characters have it.
  local function report_errors(pinfo, item, record)
    for _, known in ipairs(flags) do
      if known.expert and band(record.flags, known.flag) ~= 0 then
        add_expert(item, known.expert)
        pinfo.cols.info:append("  [" .. strformat(known.mark, record.first_at[known.flag] + 1) .. "]")
      end
    end
  end

  local escapes = {["\a"] = "\\a", ["\b"] = "\\b", ["\f"] = "\\f", ["\n"] = "\\n", ["\r"] = "\\r", ["\t"] = "\\t",
    ["\v"] = "\\v"}

  -- Invisible characters, first and last: controls, marks of text direction, and code points that never are
  -- characters, such as the last two of each plane.
  local invisible = {{0x00, 0x1F}, {0x7F, 0x9F}, {0xAD, 0xAD}, {0x600, 0x605}, {0x61C, 0x61C}, {0x6DD, 0x6DD},
    {0x70F, 0x70F}, {0x8E2, 0x8E2}, {0x180E, 0x180E}, {0x200B, 0x200F}, {0x202A, 0x202E}, {0x2060, 0x206F},
    {0xFDD0, 0xFDEF}, {0xFEFF, 0xFEFF}, {0xFFF9, 0xFFFB}, {0x110BD, 0x110BD}, {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A},
    {0xE0001, 0xE0001}, {0xE0020, 0xE007F}}

  local function is_visible(code)
    if code % 0x10000 >= 0xFFFE then return false end
    for _, range in ipairs(invisible) do
      if code <= range[2] then return code < range[1] end
    end
    return true
  end

  local function utf8_of(code)
    if code < 0x80 then return char(code) end
    local rest = char(0x80 + code % 0x40)
    code = floor(code / 0x40)
    if code < 0x20 then return char(0xC0 + code) .. rest end
    rest = char(0x80 + code % 0x40) .. rest
    code = floor(code / 0x40)
    if code < 0x10 then return char(0xE0 + code) .. rest end
    return char(0xF0 + floor(code / 0x40), 0x80 + code % 0x40) .. rest
  end

  local REPLACEMENT = "\239\191\189" -- U+FFFD, in place of what is no UTF-8
  -- How many bytes follow the first byte of a character, and which bits of that byte belong to its code.
  local leads = {{192, 223, 1}, {224, 239, 2}, {240, 247, 3}, {248, 251, 4}, {252, 253, 5}}

  -- The character that begins with the byte `lead`, which is not ASCII, and the part of `rest` that does not belong
  -- to it.
  local function beyond_ascii(lead, rest)
    local code = byte(lead)

    for _, known in ipairs(leads) do
      if code >= known[1] and code <= known[2] then
        if #rest < known[3] then return REPLACEMENT, "" end
        code = code - known[1]
        for at = 1, known[3] do
          code = code * 0x40 + byte(rest, at) - 0x80
        end
        rest = sub(rest, known[3] + 1)
        if code > 0x10FFFF or (code >= 0xD800 and code < 0xE000) then return REPLACEMENT, rest end
        if is_visible(code) then return utf8_of(code), rest end
        return strformat(code > 0xFFFF and "\\U%08X" or "\\u%04X", code), rest
      end
    end
    return REPLACEMENT, rest
  end

  -- As tvb_format_text() does it: in quotes, it would look like a C string.
  local function format_text(text)
    text = string.gsub(text, "%c", function(c)
      return escapes[c] or strformat("\\%03o", byte(c))
    end)
    return (string.gsub(text, "([\128-\255])([\128-\191]*)", function(lead, rest)
      local shown, others = beyond_ascii(lead, rest)

      return shown .. rep(REPLACEMENT, #others)
    end))
  end

  local function dissect_event(tvb, pinfo, tree, root, record)
    local name = N.sertap_events[record.event] or "Event of a later version"
    local offset, count = record.data_offset, record.values
    local text = name .. ": " .. format_text(sub(record.bytes, offset + 1, offset + count))
    local item = add(tree, FT.event, tvb, 18, 2) or root

    if tree then tree:add_packet_field(FT.text, tvb(offset, count), ENC_UTF_8) end
    if record.event == K.SERTAP_CHARACTERS_LOST or record.event == K.SERTAP_ADAPTER_LOST then
      add_expert(item, ET.event_expert, name)
    end
    write_columns(pinfo, text)
  end

  -- Whether these characters are readable text.
  local function is_text(bytes)
    local _, readable = string.gsub(bytes, "[\t\n\f\r -~]", "")

    return readable * 4 >= #bytes * 3
  end

  -- As hex and as text: a drive sends ASCII until SIS is selected.
  local function dissect_other(tvb, pinfo, tree, record)
    local offset, count, values = record.data_offset, record.count, record.values
    local shown = sub(record.bytes, offset + 1, offset + min(values, 24))
    local more = #shown < count and " ..." or ""
    local info = strformat("%d other character%s", count, plural(count))

    if values > 0 then
      add(tree, FT.data, tvb, offset, values)
      add(tree, FT.text, tvb, offset, values)
      info = info .. "  " .. hex(shown) .. more
      if is_text(shown) then info = info .. "  \"" .. format_text(shown) .. "\"" .. more end
    end
    write_columns(pinfo, info)
  end

  -- Restores the columns for a dissector that finds a frame is not its own. SIS writes both.
  local function dissect_frame(tvb, pinfo, parent, record)
    local count, values = record.count, record.values

    if record.framing ~= FRAMING_SIS or values == 0 then
      write_columns(pinfo, strformat("%d character%s", count, plural(count)))
    end
    if values == 0 then return end
    local characters = tvb(record.data_offset, values)
    -- If somebody looks at the bytes, they have a data source of their own, without the record around them.
    record.has_own_source = parent.visible and not unwanted[sertap]
    characters = record.has_own_source and characters:bytes():tvb("Characters") or tvb_of(characters)
    if record.type == K.SERTAP_FRAME or record.framing == FRAMING_SIS then
      framing_table:try(record.framing, characters, pinfo, parent)
    else -- from before a file, only telegrams of SIS explain something
      Dissector.get("data"):call(characters, pinfo, parent)
    end
  end

  -- What travels on the line is only learned from.
  local function dissect_before(tvb, pinfo, parent, root, record)
    add_expert(root, ET.before)
    dissect_frame(tvb, pinfo, parent, record)
    pinfo.cols.info:prepend("Before this file: ")
  end

  local function dissect_characters(tvb, pinfo, parent, tree, root, record)
    if tree and record.timed > 0 then add_characters(tree, tvb, record) end
    packet.record = record
    if record.type == K.SERTAP_FRAME then
      dissect_frame(tvb, pinfo, parent, record)
    elseif record.type == K.SERTAP_BEFORE then
      dissect_before(tvb, pinfo, parent, root, record)
    else
      dissect_other(tvb, pinfo, tree, record)
    end
    packet.record = nil
    if record.flags ~= 0 then report_errors(pinfo, root, record) end -- after the info column has its text
  end

  local function show_record(tvb, tree, root, record, there)
    if tree then show_header(tvb, tree, record) end
    check_count(add(tree, FT.count, tvb, 16, 2) or root, record, there)
    append_text(tree, ", " .. (N.sertap_types[record.type] or "type of a later version"))
  end

  local function dissect_record(tvb, pinfo, parent, tree, root, record)
    if record.type ~= K.SERTAP_EVENT then survey_characters(record) end
    if not packet.visited then T.line_note(record) end
    if record.type == K.SERTAP_EVENT then
      dissect_event(tvb, pinfo, tree, root, record)
    else
      dissect_characters(tvb, pinfo, parent, tree, root, record)
    end
  end

  -- Whether nothing is wrong and no tree is needed.
  local function is_quick(tree, record, bytes, there)
    return not tree and record and record.is_readable and there == record.data_offset + record.expected
      and #bytes == there
  end

  -- Whether its own dissector has already said that the capture has cut a frame.
  local function is_payload_cut(record)
    return record.type == K.SERTAP_FRAME and record.values > 0 and record.values < record.count
      and (record.framing == FRAMING_SIS or record.framing == FRAMING_3964R)
  end

  function sertap.dissector(tvb, pinfo, parent)
    local bytes, there = raw(tvb), reported_len(tvb)
    local tree = (#bytes > 0 or there == 0) and is_referenced(parent, handle) and item_add(parent, sertap, tvb()) or nil
    local root = tree or parent
    local record = #bytes >= RECORD_HEADER_SIZE and record_of(sub(bytes, 1, RECORD_HEADER_SIZE))
    local can_be_read, is_cut = is_quick(tree, record, bytes, there), false

    look_at(pinfo)
    if not can_be_read then
      can_be_read, is_cut = check_header(tvb, tree, root, bytes, there)
      if can_be_read then show_record(tvb, tree, root, record, there) end
    end
    if can_be_read then
      read_record(record, tvb, bytes, there)
      dissect_record(tvb, pinfo, parent, tree, root, record)
      if #bytes < there and not is_payload_cut(record) then S.show_cut(tvb, pinfo, parent, "SERTAP") end
    elseif is_cut then
      write_columns(pinfo, "")
      S.show_cut(tvb, pinfo, parent, "SERTAP")
    else
      write_columns(pinfo, "Record that cannot be read")
    end
  end

  handle = sertap.dissector
end

--- sis/address: kinds of station addresses in the two editions (fig. 2-9; ECODRIVE03 fig. 1-7)

do
  -- {last, kind}: an entry holds from after the one before it up to its last address.
  local receivers = {
    [K.IF02] = {
      {126, K.STATION}, {127, K.NOT_ASSIGNED}, {128, K.POINT_TO_POINT}, {199, K.RESERVED}, {253, K.GROUP},
      {254, K.LEVEL_BROADCAST}, {255, K.GLOBAL_BROADCAST},
    },
    [K.ECODRIVE03] = {{127, K.STATION}, {254, K.GROUP}, {255, K.GLOBAL_BROADCAST}},
  }
  local senders = {
    [K.IF02] = {{126, K.STATION}, {127, K.SERVICE_MASTER}, {255, K.NO_SENDER}},
    [K.ECODRIVE03] = {{127, K.STATION}, {255, K.NO_SENDER}},
  }

  -- The kind of every address, by edition.
  local function spread(editions)
    local kinds = {}

    for edition, ranges in pairs(editions) do
      local address = 0

      kinds[edition] = {}
      for _, range in ipairs(ranges) do
        for each = address, range[1] do
          kinds[edition][each] = range[2]
        end
        address = range[1] + 1
      end
    end
    return kinds
  end

  local receiver_kinds, sender_kinds = spread(receivers), spread(senders)

  function S.receiver_kind(receiver)
    return receiver_kinds[P.edition][receiver]
  end

  function S.sender_kind(sender)
    return sender_kinds[P.edition][sender]
  end

  -- Whether commands to this (last) address are answered at all: those to groups and broadcasts are not.
  function S.is_answered(receiver)
    return S.receiver_kind(receiver) < K.GROUP
  end

  local station_formats = {
    [K.GROUP] = "%d (group)",
    [K.LEVEL_BROADCAST] = "%d (all on this level)",
    [K.GLOBAL_BROADCAST] = "%d (all)",
    [K.POINT_TO_POINT] = "%d (point-to-point)",
  }
  local station_texts, numbers = {}, {} -- of every address: every telegram asks

  for edition, kinds in pairs(receiver_kinds) do
    station_texts[edition] = {}
    for station, kind in pairs(kinds) do
      station_texts[edition][station] = strformat(station_formats[kind] or "%d", station)
      numbers[station] = strformat("%d", station)
    end
  end

  -- "3", "201 (group)", "255 (all)": as in the info column.
  function S.station_text(station)
    return station_texts[P.edition][station]
  end

  -- Talker and listener as addresses, unless a lower layer has set its own. Lua has no address type for them, so only
  -- the columns get them. Those of a packet's first telegram count.
  function S.set_addresses(talker, listener)
    if packet.count > 1 or packet.port_type ~= 0 then return end
    packet.cols.src = numbers[talker]
    packet.cols.dst = numbers[listener]
  end
end

--- sis/packet-sis: header and dispatch (DOK-GENERL-SIS-DEFINIT-IF02 chapter 2; "ECODRIVE03": DOK-ECODR3-FGP-01VRS)

do
  K.START = 0x02
  K.TOKEN_PASSING = 0x0F -- what is in it is not specified
  K.CANCEL_SERVICE, K.LIST_SERVICE = 0x01, 0x04 -- cancel data transmission (chapter 4), a list of services (chapter 7)
  K.STATIC_LENGTH = 8 -- of the header; DatLW counts the bytes after it
  -- Telegram control (chapter 2.1).

  local CONTROL_RESERVED, CONTROL_WARNING, CONTROL_ERROR = K.CONTROL_RESERVED, K.CONTROL_WARNING, K.CONTROL_ERROR
  local CHECKSUM_BAD, CHECKSUM_GOOD, CHECKSUM_UNVERIFIED = 0, 1, 2

  -- The receiver's behaviour (chapter 2.4) depends on the kind of address.
  local WRONG_COMMAND = "Wrong checksum: a station on a bus does not answer, "
    .. "a point-to-point station answers with status 0xF4"
  local WRONG_REACTION = "Wrong checksum: the master waits (TwM) and sends its command again"

  local handle -- of this dissector, once there is one
  -- A TCP segment may come in several calls: only Wireshark's own table of a packet shows that it is still the same.
  function S.begin_packet(pinfo)
    if not packet.record or packet.number ~= pinfo.number then look_at(pinfo) end -- an error may have left a record
    packet.cols = pinfo.cols
    if packet.port_type ~= 0 then
      local private = pinfo.private

      if private.sis then return end
      private.sis = "begun"
    end
    packet.count, packet.telegrams = 0, 0
  end

  -- A fault: an expert item, and a mark in the info column.
  local function mark(body, item, which, text)
    add_expert(item or body.root, which)
    body.marks = body.marks .. "  [" .. text .. "]"
  end

  -- The declared length of the telegram at offset; 0: unknown (too short, or its two lengths differ).
  function S.declared_length(bytes, offset)
    local length, length_repeat = byte(bytes, offset + 3, offset + 4)

    return length_repeat and length == length_repeat and K.STATIC_LENGTH + length or 0
  end

  local summed, summed_from, summed_to, last_sum -- a telegram is summed to find its end, then to judge it

  -- Sum of bytes modulo 256; 0 for a telegram with a good checksum.
  function S.sum(bytes, offset, length)
    local sum, last = 0, offset + length

    if bytes == summed and offset == summed_from and last == summed_to then return last_sum end
    for at = offset + 1, last, CHUNK do
      sum = total(sum, byte(bytes, at, min(at + CHUNK - 1, last)))
    end
    summed, summed_from, summed_to, last_sum = bytes, offset, last, sum % 256
    return last_sum
  end

  -- A whole telegram with start character, equal lengths and a zero sum.
  function S.is_good(bytes, offset)
    local declared = S.declared_length(bytes, offset)

    return declared > 0 and offset + declared <= #bytes and byte(bytes, offset + 1) == K.START
      and S.sum(bytes, offset, declared) == 0
  end

  -- Verified only if the whole telegram and its length are there.
  local function dissect_checksum(body)
    local telegram, checksum = body.telegram, byte(body.bytes, 2)
    local item = add(body.tree, F.checksum, body.tvb, 1, 1)
    local state = CHECKSUM_UNVERIFIED

    if telegram.sum == 0 then
      state = CHECKSUM_GOOD
    elseif telegram.sum then
      state = CHECKSUM_BAD
    end
    set_generated(add_value(body.tree, F.checksum_status, body.tvb, 1, 0, state, N.checksum_states[state]))
    if state == CHECKSUM_BAD then
      append_text(item, strformat(" incorrect, should be 0x%02x", (checksum - telegram.sum) % 256))
      add_expert(item or body.root, E.checksum_bad, telegram.is_reaction and WRONG_REACTION or WRONG_COMMAND)
      body.marks = body.marks .. "  [wrong checksum]"
    else
      append_text(item, state == CHECKSUM_GOOD and " [correct]" or " [unverified]")
    end
  end

  local function dissect_lengths(body)
    local there, declared = body.there, body.declared
    local item = add(body.tree, F.length_repeat, body.tvb, 3, 1)

    if declared == 0 then
      mark(body, item, E.length_differ, "lengths differ")
    elseif there < declared then
      add_expert(item or body.root, E.length_short)
      body.marks = body.marks .. strformat("  [cut: %d of %d bytes]", there, declared)
    elseif there > declared then
      add_expert(item or body.root, E.length_long)
      body.marks = body.marks .. strformat("  [%d byte%s too many]", there - declared, plural(there - declared))
    end
  end

  -- IF02: bit 5 reserved, 6 and 7 the system state of the sender.
  local function dissect_control_if02(body, item)
    local control = body.telegram.control

    if band(control, CONTROL_RESERVED) ~= 0 then mark(body, item, E.control_reserved_set, "reserved bit") end
    if band(control, CONTROL_WARNING) ~= 0 then mark(body, item, E.control_warning_set, "system warning") end
    if band(control, CONTROL_ERROR) ~= 0 then mark(body, item, E.control_error_set, "system error") end
  end

  local ECODRIVE03_ERROR = 6

  -- ECODRIVE03: bits 5 to 7 are the state of a reaction.
  local function dissect_control_ecodrive03(body, item)
    local status = rshift(body.telegram.control, 5)
    local text = N.control_status_ecodrive03[status]

    if status == 0 then return end
    if not body.telegram.is_reaction then
      mark(body, item, E.control_reserved_set, "reserved bits")
      return
    end
    add_expert(item or body.root, status == ECODRIVE03_ERROR and E.control_status_error or E.control_status_set,
      "Status in the telegram control: " .. text)
    body.marks = body.marks .. strformat("  [control status %d: %s]", status, text)
  end

  local bits = {
    [K.IF02] = {F.control_error, F.control_warning, F.control_reserved, F.control_reaction, F.control_number,
      F.control_subaddresses},
    [K.ECODRIVE03] = {F.control_reserved_bits, F.control_reaction, F.control_number, F.control_subaddresses},
    reaction = {F.control_status, F.control_reaction, F.control_number, F.control_subaddresses}, -- of ECODRIVE03
  }

  -- SEND, FETCH or a message to several (fig. 2-3); nil: a reaction, or no chapter says so.
  local function kind_of_command(telegram)
    if telegram.is_reaction then return nil end
    local last = telegram.is_good and byte(telegram.path, -1) or telegram.receiver

    return N.message_kinds[S.receiver_kind(last)] or N.command_kinds[S.general_service(telegram.service)]
  end

  local function control_text(telegram)
    local kind = kind_of_command(telegram)

    return strformat(" (%s%s)", telegram.is_reaction and "reaction" or "command", kind and ", " .. kind or "")
  end

  local function dissect_control(body)
    local item

    if body.tree then
      local has_status = P.edition == K.ECODRIVE03 and body.telegram.is_reaction

      item = add(body.tree, F.control, body.tvb, 4, 1)
      for _, bit_field in ipairs(has_status and bits.reaction or bits[P.edition]) do
        add(item or body.tree, bit_field, body.tvb, 4, 1)
      end
      if item then append_text(item, control_text(body.telegram)) end
    end
    if body.telegram.control >= CONTROL_RESERVED then
      if P.edition == K.IF02 then dissect_control_if02(body, item) else dissect_control_ecodrive03(body, item) end
    end
  end

  local function dissect_service(body)
    local service = body.telegram.service
    local is_reserved = S.service_is_reserved(service)
    local item = add_value(body.tree, F.service, body.tvb, 5, 1, service,
      "%s (0x%02x)", S.service_range_name(service), service)

    if P.edition == K.ECODRIVE03 and not is_reserved and (service == 0x04 or (service >= 0x10 and service < 0x80)) then
      add_expert(item or body.root, E.service_reserved, "ECODRIVE03 does not have this service")
    elseif is_reserved then
      add_expert(item or body.root, E.service_reserved)
    end
  end

  local function dissect_sender(body)
    local sender = body.telegram.sender
    local kind = S.sender_kind(sender)
    local item = add_value(body.tree, F.sender, body.tvb, 6, 1, sender, "%d (%s)", sender, N.address_kinds[kind])

    if kind == K.SERVICE_MASTER then
      mark(body, item, E.sender_service_master, "service address 127")
    elseif kind == K.NO_SENDER then
      mark(body, item, E.sender_invalid, "invalid sender address")
    end
  end

  -- Faults of one address of the list.
  local function check_receiver(body, item, receiver, kind, is_last)
    if kind == K.NOT_ASSIGNED then mark(body, item, E.receiver_reserved, "address 127 is not assigned") end
    if kind == K.RESERVED then mark(body, item, E.receiver_reserved, "reserved address") end
    if kind == K.LEVEL_BROADCAST and not is_last then
      mark(body, item, E.receiver_level_broadcast, "254 before the last address")
    end
    if is_last and body.telegram.is_reaction and not S.is_answered(receiver) then
      mark(body, item, E.reaction_unexpected, "reaction to a group or broadcast")
    end
  end

  -- One address of the list: the receiver itself, or a subaddress.
  local function dissect_receiver(body, which, offset, is_last)
    local receiver = byte(body.bytes, offset + 1)
    local kind = S.receiver_kind(receiver)
    local item

    if which == F.receiver then
      item = add_value(body.tree, which, body.tvb, offset, 1, receiver, "%d (%s)", receiver, N.address_kinds[kind])
    else
      item = add(body.tree, which, body.tvb, offset, 1, receiver,
        strformat("Subaddress %d: %d (%s)", offset - K.STATIC_LENGTH + 1, receiver, N.address_kinds[kind]))
    end
    if kind ~= K.STATION then check_receiver(body, item, receiver, kind, is_last) end
  end

  -- Receiver, subaddresses and telegram number: the number comes directly after the last subaddress present.
  local function dissect_addresses(body)
    local telegram = body.telegram
    local count, number_at = telegram.subaddress_count, K.STATIC_LENGTH + telegram.subaddress_count

    dissect_sender(body)
    dissect_receiver(body, F.receiver, 7, count == 0)
    for offset = K.STATIC_LENGTH, min(number_at, body.end_) - 1 do
      dissect_receiver(body, F.subaddress, offset, offset + 1 == number_at)
    end
    if number_at < telegram.body_offset and number_at < body.end_ then
      add(body.tree, F.number, body.tvb, number_at, 1)
    end
    if body.declared > 0 and telegram.body_offset > body.declared then
      mark(body, body.root, E.length_header, "header longer than telegram")
    end
    if body.tree then
      local ends = body.ends

      add_generated(body.tree, F.talker, body.tvb, ends.talker)
      add_generated(body.tree, F.listener, body.tvb, ends.listener)
      set_hidden(add_generated(body.tree, F.station, body.tvb, ends.talker))
      set_hidden(add_generated(body.tree, F.station, body.tvb, ends.listener))
    end
  end

  -- The useful data before decoding.
  local function begin_body(body, record)
    local telegram, exchange = body.telegram, record.exchange
    local body_offset = telegram.body_offset

    body.item = body.root
    body.offset = min(body_offset, body.end_)
    body.is_cut = body.end_ < body.declared or body.declared == 0 or body_offset > body.end_
    body.is_short = false
    body.is_reaction = telegram.is_reaction
    body.service = telegram.service
    body.status = 0
    body.error = 0
    body.status_text, body.error_text, body.errors = nil, nil, nil
    body.is_explained = false
    body.summary = S.service_name(telegram.service)
    body.element = 0
    body.learn, body.data, body.text = nil, nil, nil -- what the first pass takes afterwards (sis/learn)
    body.request = not telegram.is_reaction and {service = telegram.service} or nil
    body.asked = exchange and exchange.request
    body.record = telegram.is_good and record or nil
  end

  -- The result of a telegram without a tree: {words: for the packet list, request: of a command}. A bus repeats
  -- itself, so the result is kept if it depends only on the bytes of the telegram and on one other thing. For a
  -- command, that is what the bus has taught so far. For a reaction, it is the request of its command. In a later
  -- pass it is both.
  local MOST_GIVEN = 4000
  local given, given_count -- by pass, by that thing, by the bytes

  local function forget_given()
    given, given_count = {[false] = {}, [true] = {}}, 0
  end

  at_init(forget_given)

  -- That other thing; nil if there are more, or if a tree is needed.
  local function find_grounds(body, record)
    local exchange = record.exchange

    if body.tree or not body.is_simple or not exchange or exchange.repeat_of or exchange.is_step_again
      or record.reaction_before or record.steps then
      return nil
    end
    if packet.visited then return exchange.request end
    local from = exchange.from
    if next(from.transfers) or from.phase_switch then return nil end
    if body.telegram.is_reaction then return exchange.request end
    return from.stream.bus.taught
  end

  local function keep_given(grounds, body)
    if given_count == MOST_GIVEN then forget_given() end
    local of_pass = given[packet.visited]

    of_pass[grounds] = of_pass[grounds] or {}
    of_pass[grounds][body.bytes] = {words = body.summary, request = body.request}
    given_count = given_count + 1
  end

  -- Decodes the useful data, or remembers the result. Returns words for the packet list.
  local function dissect_body(body, record)
    local grounds = find_grounds(body, record)
    local same = grounds and given[packet.visited][grounds]
    local known, before = same and same[body.bytes], effects

    if known then
      body.request = known.request
      return known.words
    end
    begin_body(body, record)
    S.dissect_body(body)
    if grounds and effects == before then keep_given(grounds, body) end
    return body.summary
  end

  -- A part of a telegram of which nobody wants a field has no tree.
  local function begin_part(body, part)
    body.tree = has_wanted[part] and body.whole_tree or nil
  end

  -- Decodes the useful data, with data of their exchange. Returns words for the packet list.
  local function dissect_useful_data(body, record)
    local telegram = body.telegram

    if telegram.is_good then S.exchange_show(record, telegram, body) end
    begin_part(body, has_wanted.head and telegram.service == K.LIST_SERVICE and "head" or "data")
    local words = dissect_body(body, record)
    if record.exchange and not telegram.is_reaction then S.learn_request(record, telegram, body.request) end
    begin_part(body, "timing")
    if not telegram.is_before then S.timing_dissect(telegram, record, body) end
    body.tree = body.whole_tree
    return words
  end

  -- "3" or, through routers, "3/2/8".
  local function route_text(receiver, subaddresses)
    local text = S.station_text(receiver)

    for at = 1, #subaddresses do
      text = text .. "/" .. S.station_text(byte(subaddresses, at))
    end
    return text
  end

  -- Who speaks to whom.
  local function stations_text(is_reaction, talker, listener, subaddresses)
    if is_reaction then return strformat("%s -> %d", route_text(talker, subaddresses), listener) end
    return strformat("%d -> %s", talker, route_text(listener, subaddresses))
  end

  -- The consequences of the real talker.
  local function ends_of(is_reaction, talker, listener, subaddresses)
    local stations = stations_text(is_reaction, talker, listener, subaddresses)
    local kind = is_reaction and "Reaction" or "Command"

    return {
      talker = talker,
      listener = listener,
      title = strformat("%s, %s", stations, kind),
      heading = strformat("%s  %s", stations, kind),
    }
  end

  -- Telegrams with the same header, from the two lengths to the last subaddress, share one table, because a bus has
  -- few different ones. It holds the header, and what read_telegram() adds.
  local telegram_of = remembered(1000, function(header)
    local _, _, control, service, sender, receiver = byte(header, 1, 6)
    local subaddress_count = band(control, K.CONTROL_SUBADDRESSES)
    local has_number = band(control, K.CONTROL_NUMBER) ~= 0
    local is_reaction = band(control, K.CONTROL_REACTION) ~= 0
    local subaddresses = sub(header, 7)

    return {
      control = control,
      service = service,
      sender = sender,
      receiver = receiver,
      subaddress_count = subaddress_count,
      has_number = has_number,
      is_reaction = is_reaction,
      -- A reaction keeps its command's addresses, unless a device has swapped them.
      as_sent = ends_of(is_reaction, sender, receiver, subaddresses),
      reversed = is_reaction and ends_of(true, receiver, sender, subaddresses),
      body_offset = K.STATIC_LENGTH + subaddress_count + (has_number and 1 or 0),
      path = sub(header, 6), -- from the receiver to the addressed station
      is_answered = S.is_answered(byte(header, -1)), -- no group or broadcast: the final receiver
      is_plain = false, -- whether such a header is known to need no note without a tree
    }
  end)

  -- Reads the header and whether the telegram is good.
  local function read_telegram(body)
    local bytes, declared = body.bytes, body.declared
    local start, _, _, _, control = byte(bytes, 1, 5)
    local subaddresses_end = K.STATIC_LENGTH + band(control, K.CONTROL_SUBADDRESSES)
    local telegram = telegram_of(sub(bytes, 3, min(subaddresses_end, body.end_)))
    local body_offset = telegram.body_offset
    local sum = declared > 0 and #bytes >= declared and S.sum(bytes, 0, declared) or nil
    local is_good = start == K.START and sum == 0 and body_offset <= declared

    body.telegram = telegram
    telegram.bytes = bytes
    telegram.declared = declared
    telegram.sum = sum -- nil: not all of it is there
    telegram.is_before = packet.record ~= nil and packet.record.type == K.SERTAP_BEFORE
    telegram.is_good = is_good
    telegram.number = is_good and telegram.has_number and byte(bytes, body_offset) or 0
    telegram.length = declared ~= 0 and min(body.there, declared) or body.there -- without what follows it
    telegram.times = S.times(body.tvb, body.there, telegram.length)
    -- Whether nothing is wrong: then, without a tree, an earlier result may be valid.
    body.is_simple = not S.is_counting and is_good and body.there == declared and #bytes == declared
  end

  local function dissect_start(body)
    local item = add(body.tree, F.start, body.tvb, 0, 1)

    if byte(body.bytes, 1) ~= K.START then mark(body, item, E.start_missing, "no start character") end
  end

  local HEAD_LENGTH = 160 -- characters: Wireshark cuts a line of the tree soon after

  -- A text of up to that many characters, followed by "..." if there are more.
  function S.shortened(words, most)
    local begins = {} -- of the characters of UTF-8

    if #words <= most then return words end
    for at in string.gmatch(words, "()[^\128-\191]") do
      begins[#begins + 1] = at
    end
    return #begins <= most and words or sub(words, 1, begins[most + 1] - 1) .. "..."
  end

  -- The header's items and its faults. Without a tree, most telegrams need no note; a header known for that is
  -- skipped.
  local function dissect_header(body)
    local telegram, before = body.telegram, effects
    local is_quick = not body.tree and body.is_simple

    if is_quick and telegram.is_plain then return end
    dissect_start(body)
    dissect_checksum(body)
    add(body.tree, F.length, body.tvb, 2, 1)
    dissect_lengths(body)
    dissect_control(body)
    dissect_service(body)
    dissect_addresses(body)
    telegram.is_plain = is_quick and effects == before
  end

  -- Header and useful data; the packet list says "16 -> 3  Command  Read parameter S-0-0044".
  local function dissect_whole_telegram(body)
    if #body.bytes < K.STATIC_LENGTH then return "" end
    read_telegram(body)
    local telegram = body.telegram
    local record = S.learn_telegram(body.pinfo, telegram)
    local ends = telegram.is_reaction and not S.is_swapped(record, telegram) and telegram.reversed or telegram.as_sent

    body.ends = ends -- the real talker and listener
    S.set_addresses(ends.talker, ends.listener)
    begin_part(body, "head")
    dissect_header(body)
    local words = dissect_useful_data(body, record)
    add_bytes(body.tree, F.raw, body.tvb, body.end_, #body.bytes)
    if S.is_counting and not telegram.is_before then S.note_telegram(body, record) end

    if body.tree and not unwanted[sis] then
      append_text(body.root, strformat(", %s, %s", ends.title, S.shortened(words, HEAD_LENGTH)))
    end
    return ends.heading .. body.marks .. "  " .. words
  end

  -- Fewer than the 8 bytes of every telegram.
  local function dissect_stump(body)
    local there = body.there

    dissect_start(body)
    add_bytes(body.tree, F.raw, body.tvb, 1, body.end_)
    add_expert(body.root, E.length_short)
    return strformat("Cut telegram, %d of at least %d bytes%s", there, K.STATIC_LENGTH, body.marks)
  end

  -- Neither a start character nor a valid length: addresses would be invented.
  local function dissect_no_telegram(body)
    if body.tree then append_text(body.root, ", not a telegram") end
    add_expert(body.root, E.start_missing)
    add(body.tree, F.raw, body.tvb, 0, #body.bytes)
    return strformat("Not a telegram, %d byte%s", body.there, plural(body.there))
  end

  -- sis/packed: each telegram of a packet but the first says which fields it has.

  local function begin_packed(tree)
    counts = packet.telegrams > 0 and is_wanted(tree, F.packed) and {} or nil
    packet.telegrams = packet.telegrams + 1
  end

  local function tell_packed(tree, tvb)
    if not counts then return end
    local parts, of_name = {}, {}

    for which, times in pairs(counts) do
      parts[#parts + 1], of_name[name_of[which]] = name_of[which], times
    end
    counts = nil
    if #parts == 0 then return end
    table.sort(parts)
    for place, name in ipairs(parts) do
      parts[place] = strformat("%s=%d", name, of_name[name])
    end
    set_hidden(add(tree, F.packed, tvb, 0, 0, concat(parts, " ")))
  end

  -- The telegram being dissected, and its useful data: one table for all of them, because making tables would take
  -- longer than the rest.
  local body = {}

  -- One telegram: `tvb` begins with it and has nothing of the next, `bytes` are its captured bytes, and `there` of
  -- them were on the line. Returns the words for the info column.
  function S.dissect_telegram(tvb, bytes, pinfo, parent, there)
    local declared = S.declared_length(bytes, 0)
    local tree = is_referenced(parent, handle) and item_add(parent, sis, tvb()) or nil

    body.tvb, body.bytes, body.pinfo = tvb, bytes, pinfo
    body.tree, body.whole_tree, body.root = tree, tree, tree or parent
    body.there, body.declared = there, declared -- 0: its two lengths differ, or are missing
    body.end_ = min(declared > 0 and declared or there, #bytes) -- available bytes of the telegram
    body.marks = "" -- for the end of the info column: what is wrong
    begin_packed(tree)
    local words = (byte(bytes, 1) ~= K.START and declared ~= there and dissect_no_telegram
      or there < K.STATIC_LENGTH and dissect_stump or dissect_whole_telegram)(body)

    tell_packed(tree, tvb)
    return words
  end

  -- Where the telegram at offset ends: at its declared length if another one starts there, else with the data.
  -- A damaged one also ends where a good one begins: if a character was lost, its length counts the first one of the
  -- next.
  local function telegram_extent(bytes, offset, there)
    local declared = S.declared_length(bytes, offset)
    local is_followed = declared > 0 and byte(bytes, offset + declared + 1) == K.START
    local last = is_followed and offset + declared or #bytes

    if declared <= #bytes - offset and not S.is_good(bytes, offset) then
      local start = string.find(bytes, char(K.START), offset + 2, true)

      while start and start <= last do
        if S.is_good(bytes, start - 1) then return start - 1 - offset end
        start = string.find(bytes, char(K.START), start + 1, true)
      end
    end
    return is_followed and declared or there - offset
  end

  -- A packet as long as Wireshark allows would have more telegrams than Wireshark can show.
  local function dissect_rest(tvb, offset, parent, there)
    local rest = tvb(offset)
    local tree = parent:referenced(handle) and parent:add(sis, rest) or nil

    begin_packed(tree)
    append_text(tree, ", not decoded")
    add_expert(tree or parent, E.telegrams_many)
    add(tree, F.raw, tvb, offset, rest:len())
    tell_packed(tree, rest:tvb())
    packet.cols.info:append(strformat(" | Not decoded, %d byte%s", there - offset, plural(there - offset)))
  end

  function S.dissect_packet(tvb, pinfo, tree)
    local bytes, offset = raw(tvb), 0

    S.begin_packet(pinfo)
    local there = T.reported_len(tvb)
    local cols = packet.cols
    cols.protocol = "SIS"
    while offset < min(#bytes, K.MOST_DISSECTED) do
      local extent = telegram_extent(bytes, offset, there)
      local is_alone = offset == 0 and extent == there
      local part = is_alone and tvb or tvb(offset, min(extent, #bytes - offset)):tvb()
      local info = S.dissect_telegram(part, is_alone and bytes or part:raw(), pinfo, tree, extent)

      if offset == 0 then cols.info = info else cols.info:append(" | " .. info) end
      offset = offset + extent
    end
    if offset < #bytes then dissect_rest(tvb, offset, tree, there) end
    if #bytes < there then
      if offset == 0 then cols.info = "" end
      S.show_cut(tvb, pinfo, tree, "SIS")
    end
  end

  -- TCP may split telegrams over segments and pack them into one: sis-transports.
  function sis.dissector(tvb, pinfo, tree)
    if pinfo.port_type ~= 0 and S.is_before(pinfo) then return 0 end
    if pinfo.port_type == K.PORT_TYPE_TCP then return S.dissect_segment(tvb, pinfo, tree) end
    S.dissect_packet(tvb, pinfo, tree)
  end

  handle = sis.dissector
end

--- sis/body, sis/dispatch: the useful data of one service, and what all of the services need (chapters 2.1 and 2.3)

do
  -- For each general service, the function that decodes its body: the following blocks fill it.
  S.bodies = {}

  local general_services = {} -- every telegram needs it several times

  at_init(function() general_services = {} end)

  local function find_general_service(service)
    for name, like in pairs(K.LIKE_IF_SET) do
      if P[name] and like[service] then return like[service] end
    end
    return K.LIKE[service] or service
  end

  -- 0x10 for 0x10, 0x80, 0x90: the general service that corresponds to a product group's service, else the service
  -- itself.
  function S.general_service(service)
    local general = general_services[service]

    if not general then
      general = find_general_service(service)
      general_services[service] = general
    end
    return general
  end

  local function is_in(number, ranges)
    for _, range in ipairs(ranges) do
      if number >= range[1] and number <= range[2] then return true end
    end
    return false
  end

  -- Whether a reaction of this service begins with a status byte.
  function S.has_status(service)
    return is_in(service, K.WITH_STATUS) or S.general_service(service) ~= service
  end

  -- Whether a body begins with parameter control and device address.
  function S.has_control_byte(service)
    return is_in(S.general_service(service), K.WITH_CONTROL)
  end

  -- Whether a reaction with this subservice may answer a command with that one. A subservice that is not defined tells
  -- nothing: fig. 2-13 answers 0x01 with 0xF1.
  function S.may_answer_subservice(service, asked, answered)
    local defined = K.LAYOUTS[service] and K.LAYOUTS[service].subservices

    return not defined or asked == answered or not defined[answered]
  end

  -- Whether the telegram is a good one, whose exchange is known.
  function S.has_exchange(body)
    return body.record and body.record.exchange
  end

  function S.left(body)
    return body.end_ - body.offset
  end

  -- Words for the packet list.
  function S.say(body, format, ...)
    body.summary = body.summary .. strformat(format, ...)
  end

  -- A fault, for the packet list and as an expert item of the last field read.
  function S.mark(body, which, format, ...)
    local text = strformat(format, ...)

    add_expert(body.item or body.root, which, text)
    body.marks = body.marks .. "  [" .. text .. "]"
  end

  -- Whether that many bytes are left for a field. One note is enough: nothing else can follow.
  function S.needs(body, which, size)
    if body.end_ - body.offset >= size and not body.is_short then return true end
    if not body.is_cut and not body.is_short then
      body.item = body.root
      S.mark(body, E.body_missing, "%s missing", label[which])
    end
    body.is_short = true
    return false
  end

  local function get_value(body, size)
    local a, b, c, d = byte(body.bytes, body.offset + 1, body.offset + size)

    return a + (b or 0) * 0x100 + (c or 0) * 0x10000 + (d or 0) * 0x1000000
  end

  -- Adds `size` bytes, little endian, as a field, and returns their value; body.item is set. If bytes are missing,
  -- adds a note once per body and returns nil.
  function S.take(body, which, size)
    if not S.needs(body, which, size) then return nil end

    local value, offset = get_value(body, size), body.offset
    body.item = add_le(body.tree, which, body.tvb, offset, size)
    body.offset = offset + size
    return value
  end

  -- A code as "Text (0x12)", of `size` bytes.
  local function add_code(body, which, size, value, text, digits)
    body.item = add_value(body.tree, which, body.tvb, body.offset, size, value, "%s (0x%0" .. digits .. "x)", text,
      value)
    body.offset = body.offset + size
  end

  -- The same for a code whose text depends on the service. Returns value and text.
  function S.take_code(body, which, size, texts)
    if not S.needs(body, which, size) then return nil end

    local value = get_value(body, size)
    local text = texts[value] or "Not defined"
    add_code(body, which, size, value, text, size * 2)
    return value, text
  end

  -- The rest of the body as bytes; false if there is none.
  function S.take_rest(body, which)
    local left = body.end_ - body.offset

    if left == 0 or body.is_short then return false end
    body.item = add(body.tree, which, body.tvb, body.offset, left)
    body.offset = body.end_
    return true
  end

  -- Remembers the device of a command.
  function S.request_device(body, device)
    if body.request then
      body.request.has_device = true
      body.request.device = device
    end
  end

  -- Device address and subservice, the first fields of services that have subservices. Returns the subservice.
  function S.take_subservice(body)
    local texts, device = K.LAYOUTS[body.service].subservices, S.take(body, F.device, 1)

    if not device then return nil end
    S.request_device(body, device)
    local subservice, text = S.take_code(body, F.subservice, 1, texts)
    if not subservice then return nil end
    if texts[subservice] then
      S.say(body, ": %s", text)
    else
      S.mark(body, E.body_note, "subservice 0x%02x is not defined", subservice)
    end
    if body.request then body.request.subservice = subservice end
    return subservice
  end

  local function visible_character(c)
    local code = byte(c)

    if code < 0x20 then return "\226\144" .. char(0x80 + code) end
    if code == 0x7F then return "\226\144\161" end
    if code < 0xA0 or code == 0xAD then return strformat("<%02x>", code) end
    return code < 0xC0 and "\194" .. c or "\195" .. char(code - 0x40)
  end

  -- Characters as a person reads them, all of them. They are Latin-1; control characters are shown as their pictures
  -- (U+2400 and following), those that only Latin-1 has, and the soft hyphen, by their codes: "<9b>".
  function S.text(bytes)
    return (string.gsub(bytes, "[^ -~]", visible_character))
  end

  -- The rest of the body as text, and into the summary.
  function S.take_text(body, which)
    local offset, length = body.offset, body.end_ - body.offset

    if not S.needs(body, which, 1) then return end
    local text = S.text(sub(body.bytes, offset + 1, body.end_))
    body.item = add(body.tree, which, body.tvb, offset, length, text)
    S.say(body, ": \"%s\"", text)
    body.text = text
    body.offset = body.end_
  end

  local baud_bits = {}

  for baud_bit in pairs(N.baud_masks) do
    baud_bits[#baud_bits + 1] = baud_bit
  end
  table.sort(baud_bits)

  -- The rates of a mask, and its undefined bits.
  local function baud_mask_text(mask, several)
    local rates, unknown = {}, mask

    for _, baud_bit in ipairs(baud_bits) do
      local is_set = band(mask, baud_bit) ~= 0

      if is_set then unknown = unknown - baud_bit end
      if is_set or (baud_bit == 0 and (several or mask == 0)) then -- 9600 is always supported
        rates[#rates + 1] = N.baud_masks[baud_bit]
      end
    end
    if unknown ~= 0 then rates[#rates + 1] = strformat("0x%02x (not defined)", unknown) end
    return concat(rates, ", "), unknown
  end

  -- A mask of baud rates; of several rates only where `several` are allowed. Adds them to the summary. Gives the rate
  -- where it is one, else nil.
  function S.take_baud_mask(body, several)
    local mask = S.take(body, F.init_baud_mask, 1)

    if not mask then return nil end
    local text, unknown = baud_mask_text(mask, several)
    append_text(body.item, " (" .. text .. ")")
    S.say(body, ": %s", text)
    if not several and band(mask, mask - 1) ~= 0 then S.mark(body, E.body_note, "more than one baud rate") end
    if unknown ~= 0 then S.mark(body, E.body_note, "undefined bits of the baud rate mask") end
    return tonumber(N.baud_masks[mask])
  end

  local function mark_error(body, text, code)
    S.mark(body, E.status_execution_error, "error 0x%04x: %s", code, text)
    body.is_explained = true
    body.error, body.error_text = code, text
  end

  -- The error code of the service instead of useful data: two bytes, with advice for some codes ...
  function S.take_error(body, texts, advice)
    local code, text = S.take_code(body, F.error, 2, texts)

    if not code then return end
    if advice and advice[code] then append_text(body.item, ": " .. advice[code]) end
    mark_error(body, text, code)
  end

  -- ... or one byte, which forms a code together with the subservice.
  function S.take_error_byte(body, subservice, texts)
    if not S.needs(body, F.error, 1) then return end

    local code = subservice * 0x100 + get_value(body, 1)
    local text = texts[code] or "Not defined"
    add_code(body, F.error, 1, code, text, 4)
    mark_error(body, text, code)
  end

  -- A reaction without error; its useful data follow.
  function S.is_ok(body)
    return body.status == 0 and not body.is_short
  end

  -- After a status that is neither good nor the service's own error: takes the rest; false for those two.
  function S.take_channel_error(body)
    if body.status == 0x02 then
      S.take_error(body, N.errors_channel, N.advice_channel)
    elseif body.status > 0x02 and body.status < 0xF0 then
      S.take_rest(body, F.raw) -- not documented
    end
    return body.status >= 0x02
  end

  local size_of = {[ftypes.UINT8] = 1, [ftypes.UINT16] = 2, [ftypes.UINT32] = 4} -- bytes of an integer

  -- As its field says: text, bytes, a code or a number.
  local function take_item(body, which, size, codes)
    local kind, left = kind_of[which], S.left(body)

    if kind == ftypes.STRING then
      S.take_text(body, which)
    elseif kind == ftypes.BYTES then
      S.needs(body, which, 1)
      if S.take_rest(body, which) then S.say(body, ", %d byte%s", left, plural(left)) end
    elseif size ~= size_of[kind] then
      S.take_rest(body, F.raw) -- protocol/checks.py lets none pass; Wireshark ends when a time has a wrong size
    elseif codes then
      local value, text = S.take_code(body, which, size, codes)

      if not value then return end
      S.say(body, ", %s", text)
      if not codes[value] then S.mark(body, E.body_note, "0x%0" .. size * 2 .. "x is not defined", value) end
    else
      local value = S.take(body, which, size)

      if value then S.say(body, base_of[which] == base.HEX and ", 0x%0" .. size * 2 .. "x" or ", %d", value) end
    end
  end

  -- What follows a subservice: each item by the function of its name, or as its field says. Bytes that no document
  -- defines are shown raw.
  function S.take_layout(body, layout, functions)
    if not layout then
      S.take_rest(body, F.raw)
      return
    end
    for _, item in ipairs(body.is_reaction and layout.reaction or layout.command) do
      local name, size, may_be_missing, codes = unpack(item, 1, 4)

      if not may_be_missing or S.left(body) >= size then
        if functions[name] then functions[name](body, size) else take_item(body, F[name], size, codes) end
      end
    end
  end

  -- What follows a subservice in a command or a good reaction, or an error.
  function S.take_layout_or_error(body, subservice, functions)
    local service = K.LAYOUTS[body.service]

    if not body.is_reaction or S.is_ok(body) then
      S.take_layout(body, service[subservice], functions)
    elseif S.take_channel_error(body) then
      return
    elseif service.errors then
      S.take_error_byte(body, subservice, service.errors)
    else
      S.take_rest(body, F.raw) -- not documented
    end
  end

  -- A service whose layouts say all.
  local function dissect_by_layout(body)
    local subservice = not K.LAYOUTS[body.service].subservices and 0 or S.take_subservice(body)

    if subservice then S.take_layout_or_error(body, subservice, {}) end
  end

  for service, layouts in pairs(K.LAYOUTS) do
    if layouts.is_by_layout then S.bodies[service] = dissect_by_layout end
  end

  local function take_status(body)
    if not S.needs(body, F.status, 1) then return end

    local status, general = get_value(body, 1), S.general_service(body.service)
    local is_phase_service = general == 0x12 or general == 0x1D
    local text = is_phase_service and N.status_phase[status] or range_text(status, N.status)
    body.status = status
    body.status_text = text
    add_code(body, F.status, 1, status, text, 2)
    body.status_item = body.item or body.root
  end

  -- An error code says more, and is an item of its own.
  local function mark_status(body)
    if body.status == 0 or body.is_explained then return end
    local kind = body.status < 0xF0 and E.status_execution_error or E.status_telegram_error

    add_expert(body.status_item, kind, "Status: " .. body.status_text)
    body.marks = body.marks .. "  [status: " .. body.status_text .. "]"
  end

  local function dissect_undocumented(body)
    if body.is_reaction and S.has_status(body.service) and S.take_channel_error(body) then return end
    if S.take_rest(body, F.raw) then
      S.mark(body, E.body_note, "no document says what is in it")
    elseif body.service < K.TOKEN_PASSING and not body.is_cut then
      S.mark(body, E.body_note, "no document defines this service")
    end
  end

  -- Bytes that no field has used: an incomplete field, or more than the service has.
  local function show_leftover(body)
    local left = body.end_ - body.offset

    if left == 0 then return end
    body.item = add(body.tree, F.raw, body.tvb, body.offset, left)
    if not body.is_short and not body.is_cut then
      S.mark(body, E.body_unexpected, "more bytes than this service has")
    end
    body.offset = body.end_
  end

  -- Status byte first.
  local function decode(body)
    local dissect = S.bodies[S.general_service(body.service)]

    if not dissect and body.service >= 0x80 and not S.service_is_reserved(body.service)
      and string.find(sub(body.bytes, body.offset + 1, body.end_), "^[ -~][\t\n\f\r -~]*$") then
      S.take_text(body, F.text) -- an ASCII record of a product group, without a status (chapter 2.1)
      return
    end
    if body.is_reaction and S.has_status(body.service) then take_status(body) end
    -- After a telegram error even the useful data header may be missing.
    if not body.is_short and (body.status < 0xF0 or body.end_ > body.offset) then
      (dissect or dissect_undocumented)(body)
    end
    mark_status(body)
  end

  -- Decodes a whole body, learns from it, and shows what is known by then.
  function S.dissect_body(body)
    local has_exchange = S.has_exchange(body)

    decode(body)
    if has_exchange then
      S.learn_body(body)
      S.show_switch(body)
    end
    show_leftover(body)
    if has_exchange then S.sequence_show(body) end
  end
end

--- sis/services/identification: service 0x00, node identification (chapter 3)

do
  local VERSION_LENGTH, VERSION = 5, "^[0-9][0-9]V[0-9][0-9]$" -- "nnVmm"

  local items = {}

  function items.version(body)
    local left = S.left(body)

    if left ~= VERSION_LENGTH and not body.is_cut then
      S.mark(body, left < VERSION_LENGTH and E.body_missing or E.body_unexpected, "a SIS version has %d characters",
        VERSION_LENGTH)
    elseif left == VERSION_LENGTH and not string.find(sub(body.bytes, body.offset + 1, body.end_), VERSION) then
      S.mark(body, E.body_note, "a SIS version has the form nnVmm")
    end
    S.take_text(body, F.version)
  end

  -- Tells the type of the device.
  local function take_identity(body, which, what)
    local is_too_long = S.left(body) > K.MOST_CHARACTERS

    S.take_text(body, which)
    if is_too_long then S.mark(body, E.body_note, "more than %d characters", K.MOST_CHARACTERS) end
    body.learn = function() S.station_identify(body, what) end
  end

  function items.firmware(body) take_identity(body, F.firmware, "firmware") end

  function items.type_key(body) take_identity(body, F.type_key, "type key") end

  function items.init_baud_mask(body) S.take_baud_mask(body, true) end

  S.bodies[0x00] = function(body)
    local subservice = S.take_subservice(body)

    if subservice and body.is_reaction then S.take_layout_or_error(body, subservice, items) end
  end
end

--- sis/services/cancel: service 0x01, cancel data transmission (chapter 4)

do

  local function take_ambiguous(body)
    if body.request then
      body.request.is_ambiguous = true
      body.request.subservice = byte(body.bytes, body.offset + 1)
    end
    S.take_rest(body, F.raw)
    S.mark(body, E.body_note, "device address or service, one byte does not tell")
  end

  local function take_device_and_service(body)
    local device = S.take(body, F.device, 1)
    local service = device and S.take(body, F.canceled_service, 1)

    if not service then return end
    S.request_device(body, device)
    if body.request then
      body.request.has_subservice = true
      body.request.subservice = service
    end
    S.say(body, ", %s, device %d", S.service_name(service), device)
    if S.general_service(service) == 0x1D then -- chapter 8.5
      S.mark(body, E.body_note, "a phase switch cannot be cancelled")
    end
  end

  local function dissect_command(body)
    local left = S.left(body)

    if left == 0 then
      S.say(body, ", all that is under way")
    elseif left == 1 then
      take_ambiguous(body)
    else
      take_device_and_service(body)
    end
  end

  -- The address is repeated if the command had one. The length of error data is not documented, but they follow an
  -- error only.
  local function dissect_reaction(body)
    local had_device = body.asked and body.asked.has_device
    local is_open = not body.asked or body.asked.is_ambiguous -- whether it had
    local is_alone = is_open and S.left(body) == 1 and body.status == 0
    local is_before_code = is_open and S.left(body) == 3 and body.status == 0x02

    if (had_device or is_alone or is_before_code) and not S.take(body, F.device, 1) then return end
    if body.status == 0x02 and S.left(body) >= 2 then
      S.take_channel_error(body)
    elseif body.status ~= 0 and body.status < 0xF0 then
      S.take_rest(body, F.raw)
    end
  end

  S.bodies[0x01] = function(body)
    if body.is_reaction then dissect_reaction(body) else dissect_command(body) end
  end
end

--- sis/services/flash: service 0x02, flash operation (chapter 5)

do
  local ERASE_FLASH = 0x94
  local FIRST_SUPPORTED_TYPE = 2 -- of a device: RAM
  local items = {}

  function items.flash_address(body, size)
    local address = S.take(body, F.flash_address, size)

    if not address then return end
    S.say(body, ", 0x%08x", address)
  end

  local function check_most(body, length, most)
    if length > most then S.mark(body, E.body_note, "more than %d bytes", most) end
  end

  function items.flash_length(body, size)
    local length = S.take(body, F.flash_length, size)

    if not length then return end
    S.say(body, ", %d byte%s", length, plural(length))
    if size == 1 then
      check_most(body, length, K.MOST_READ)
      body.request.setting = length
    end
  end

  function items.data(body)
    local length = S.left(body)

    if not S.needs(body, F.data, 1) then return end
    S.take_rest(body, F.data)
    S.say(body, ", %d byte%s", length, plural(length))
    local asked = body.is_reaction and body.asked and body.asked.setting or 0

    if not body.is_reaction then
      check_most(body, length, K.MOST_PROGRAMMED)
    elseif length < asked and not body.is_cut then
      S.mark(body, E.body_note, "fewer bytes than asked for")
    elseif asked > 0 and length > asked then
      S.mark(body, E.body_note, "more bytes than asked for")
    end
  end

  function items.flash_device_type(body, size)
    local kind, text = S.take_code(body, F.flash_device_type, size, N.device_types)

    if not kind then return end
    S.say(body, ", %s", text)
    if not N.device_types[kind] then
      S.mark(body, E.body_note, "0x%02x is not defined", kind)
    elseif kind < FIRST_SUPPORTED_TYPE then
      S.mark(body, E.body_note, "device types 0 and 1 are not supported")
    end
  end

  local ERASE_EVERYTHING = " (complete erase without loader and kernel)"

  -- Both numbers 0xFFFFFFFF (fig. 5-15).
  local function take_erase_everything(body)
    if S.left(body) < 8 or sub(body.bytes, body.offset + 1, body.offset + 8) ~= rep("\255", 8) then return false end
    S.take(body, F.flash_address, 4)
    append_text(body.item, ERASE_EVERYTHING)
    S.take(body, F.flash_length, 4)
    append_text(body.item, ERASE_EVERYTHING)
    S.say(body, ", all but loader and kernel")
    return true
  end

  S.bodies[0x02] = function(body)
    local subservice = S.take_subservice(body)

    if not subservice then return end
    if not body.is_reaction and subservice == ERASE_FLASH and take_erase_everything(body) then return end
    S.take_layout_or_error(body, subservice, items)
  end
end

--- sis/services/initialization: service 0x03, initialization of the SIS communication (chapter 6)

do
  -- "Set TzA" of "Set TzA (character interval)".
  local function short_text(text)
    return string.match(text, "^(.-) %(") or text
  end

  local function take_time(body, which)
    if not S.needs(body, which, 2) then return nil end

    local offset = body.offset
    local ms = body.tvb(offset, 2):le_uint()
    body.item = add_duration(body.tree, which, body.tvb, offset, 2, ms * 1000000, "%d ms", ms)
    body.offset = offset + 2
    S.say(body, which == F.init_time and " = %d ms" or ", %d ms", ms)
    return ms
  end

  local items, layouts = {}, K.LAYOUTS[0x03]

  function items.init_time(body)
    body.request.setting = take_time(body, F.init_time)
  end

  function items.init_test_time(body)
    body.request.test_ms = take_time(body, F.init_test_time)
  end

  -- A mask without a rate sets nothing.
  function items.init_baud_mask(body)
    body.request.setting = S.take_baud_mask(body, false)
    if not body.request.setting then body.request.has_setting = false end
  end

  -- The data of a subservice in a command; its request has a setting if they are complete.
  local function take_setting(body, subservice, request)
    local first, layout = body.request, layouts[subservice]

    if not layout then
      if S.take_rest(body, F.raw) and N.subservices_initialization[subservice] then
        S.mark(body, E.body_note, "no document says what is in it") -- what is not defined has its note already
      end
      return
    end
    body.request = request
    request.has_setting = true
    S.take_layout(body, layout, items)
    if body.is_short then request.has_setting = false end
    body.request = first
  end

  -- The bytes of a subservice's data. A reaction has none.
  local function size_of_setting(body, layout)
    local size = 0

    if not body.is_reaction then
      for _, item in ipairs(layout.command) do
        size = size + item[2]
      end
    end
    return size
  end

  -- Whether the rest is entirely further subservices of fixed length (chapter 6.1), each with the device address
  -- before it or without. A reaction has those of its command.
  local function is_layout(body, device, has_device)
    local asked, at, head = body.asked and body.asked.list, body.offset, has_device and 2 or 1

    while at + head <= body.end_ do
      local subservice = byte(body.bytes, at + head)
      local layout = layouts[subservice]

      if not layout or (has_device and byte(body.bytes, at + 1) ~= device) then return false end
      if body.is_reaction and body.asked and (not asked or asked.subservice ~= subservice) then return false end
      asked = asked and asked.next
      at = at + head + size_of_setting(body, layout)
    end
    return at == body.end_
  end

  -- Another subservice of a command is another request.
  local function add_request(body, device, subservice)
    local first = body.request
    local request = {service = body.service, has_device = true, device = device, subservice = subservice}

    if first.list then first.last.next = request else first.list = request end
    first.last = request
    return request
  end

  local function take_further(body, device, has_device)
    if has_device then S.take(body, F.device, 1) end
    local subservice, text = S.take_code(body, F.subservice, 1, N.subservices_initialization)

    S.say(body, "; %s", short_text(text))
    if body.request then take_setting(body, subservice, add_request(body, device, subservice)) end
  end

  -- The documents do not say whether the device address comes once or before each subservice: the layout that fits
  -- all bytes counts.
  local function take_all_further(body, device)
    if S.left(body) == 0 or body.is_short or body.is_cut then return end
    local is_once, is_each = is_layout(body, device, false), is_layout(body, device, true)

    if is_once == is_each then
      S.take_rest(body, F.raw)
      S.mark(body, E.body_note, "more data: %s",
        is_once and "further subservices, but which is not certain" or "no further subservices fit them")
      return
    end
    while S.left(body) > 0 do
      take_further(body, device, is_each)
    end
  end

  S.bodies[0x03] = function(body)
    local device = byte(body.bytes, body.offset + 1)
    local subservice = S.take_subservice(body)

    if not subservice then return end
    if N.subservices_initialization[subservice] then
      body.summary = short_text(N.subservices_initialization[subservice]) -- it says all, the service's name is long
    end
    if not body.is_reaction then take_setting(body, subservice, body.request) end
    if not body.is_reaction or S.is_ok(body) then
      take_all_further(body, device)
    elseif not S.take_channel_error(body) then
      S.take_error_byte(body, subservice, N.errors_initialization)
    end
    body.learn = S.bus_learn
  end
end

--- sis/dispatch: service 0x04, execute a list of SIS services (chapter 7): each element is the telegram it stands for

do
  local LIST_SERVICE = K.LIST_SERVICE
  local SHORTEST_ELEMENT, CHANNEL_CODE = 3, 2 -- bytes

  local function add_request(list, number, request)
    local last = list.last_request

    request.place = number
    if last then last.next = request else list.request.list = request end
    list.last_request = request
  end

  -- Whether an element of a reaction, `length` bytes after its service, may answer this command: as whole telegrams
  -- are compared (sis/exchange).
  local function is_answer_to(command, list, service, length)
    if command.service ~= service then return false end
    if not command.has_device or length < 3 then return true end
    local first, second = byte(list.bytes, list.offset + 2, list.offset + 3) -- after the status

    if S.has_control_byte(service) then
      return command.element == band(rshift(first, 3), 7) and command.device == second
    end
    return S.may_answer_subservice(service, command.subservice or 0, second)
  end

  local function find_command(from, list, service, length)
    while from and not is_answer_to(from, list, service, length) do
      from = from.next
    end
    return from
  end

  -- What the exchange keeps for an element; of a command, in the second pass, it is the next one. No document says
  -- whether a station may leave elements out. If it did, an element that fits two commands belongs to neither.
  local function take_command(commands, list, service, length)
    local command, is_reaction = commands.next, list.is_reaction

    if is_reaction then command = find_command(command, list, service, length) end
    if not command then return nil end
    if is_reaction and not commands.is_each_answered and find_command(command.next, list, service, length) then
      return nil
    end
    commands.next = command.next
    return command
  end

  -- The body of an element, `length` bytes after its service, as if it were alone in a telegram.
  local function dissect_element_body(list, root, number, service, length, commands)
    local element = {
      telegram = list.telegram,
      tvb = list.tvb,
      bytes = list.bytes,
      pinfo = list.pinfo,
      tree = list.tree,
      root = root or list.root,
      item = root,
      offset = list.offset,
      end_ = list.offset + length,
      is_cut = list.is_cut and list.offset + length == list.end_,
      element = number,
      is_reaction = list.is_reaction,
      service = service,
      status = 0,
      error = 0,
      record = list.record,
      summary = S.service_name(service),
      marks = "",
      asked = take_command(commands, list, service, length),
      ends = list.ends,
    }

    if list.is_reaction and list.asked and not element.asked then
      list.item = root
      S.mark(list, E.body_note, "which element of the command this answers is unknown")
    end
    if not list.is_reaction then
      element.request = {service = service}
      add_request(list, number, element.request)
    end
    S.dissect_body(element)
    commands.is_one_unknown = commands.is_one_unknown or element.status ~= 0 or not S.has_status(service)
    if element.error_text then
      list.errors = list.errors or {}
      table.insert(list.errors, strformat("0x%04x %s", element.error, element.error_text))
    end
    if list.is_reaction and list.status == 0 and element.status ~= 0 then
      list.item = root
      S.mark(list, E.body_note, "the overall status is 0, that of this element is not")
    end
    if list.status < 0xF0 then -- else it has data of its own
      list.is_explained = list.is_explained or element.is_explained or element.status ~= 0
    end
    local text = element.summary .. element.marks
    append_text(root, ": " .. text)
    S.say(list, "; %s", text)
  end

  -- The following elements still have their commands.
  local function show_recursion(list, number, length, commands)
    commands.is_one_unknown = true
    take_command(commands, list, LIST_SERVICE, length)
    if not list.is_reaction then add_request(list, number, {service = LIST_SERVICE}) end
    S.mark(list, E.list_recursion, "a list in a list")
    if length > 0 then add(list.tree, F.raw, list.tvb, list.offset, length) end
  end

  -- What an element stands for, `length` bytes after its service of which `there` are there.
  local function dissect_element_service(list, root, number, length, there, commands)
    local service = S.take(list, F.service, 1)

    if not service then return end
    if length > there and not list.is_cut then
      S.mark(list, E.body_missing, "an element is cut")
      list.is_cut = true -- so its missing field has no note
    end
    if service == LIST_SERVICE then
      show_recursion(list, number, there, commands)
    else
      dissect_element_body(list, root, number, service, there, commands)
    end
    list.offset = list.offset + there
  end

  -- Length, service, body.
  local function dissect_element(list, number, commands)
    local left, length = S.left(list), byte(list.bytes, list.offset + 1)
    local size, outer = min(length + 1, left), list.tree
    local root = add_subtree(outer, list.tvb, list.offset, size, strformat("Element %d", number))

    list.tree = root
    S.take(list, F.element_length, 1)
    if length == 0 then
      S.mark(list, E.body_unexpected, "an element is empty")
    else
      dissect_element_service(list, root, number, length - 1, size - 2, commands)
    end
    list.tree = outer
  end

  -- The commands of a list that a reaction answers: those that no element has answered yet, and whether there are as
  -- many in the reaction, or fewer. (is_one_unknown: an element of it may have failed, or has.)
  local function commands_of(list)
    local first = list.asked and list.asked.list
    local command, at = first, list.offset

    while at < list.end_ do
      local length = byte(list.bytes, at + 1)

      at = at + 1 + length
      if length > 0 then -- else no element
        if not command then return {next = first} end -- more than there are commands
        command = command.next
      end
    end
    return {next = first, is_each_answered = not command, is_one_missing = command ~= nil}
  end

  -- Service 0x04 has no codes of its own: its overall status is 0 or 1, and its list follows also after an error
  -- (chapter 7.1). Only the codes of the channel are those of all services (fig. 2-19). Tells whether no list follows.
  local function take_overall_error(body)
    local left = S.left(body)
    local code = left == CHANNEL_CODE and S.little_endian(body.bytes, body.offset + 1, CHANNEL_CODE)

    if body.status ~= 0x02 or left < CHANNEL_CODE or code and N.errors_channel[code] then
      return S.take_channel_error(body)
    end
    body.item = body.root
    S.mark(body, E.body_note, "the overall status of a list is 0 or 1")
    if left < SHORTEST_ELEMENT then S.take_rest(body, F.raw) end
    return left < SHORTEST_ELEMENT
  end

  S.bodies[LIST_SERVICE] = function(body)
    local number = 1

    body.last_request = nil -- of its elements

    if body.is_reaction and take_overall_error(body) then return end
    if S.left(body) == 0 and not body.is_cut then S.mark(body, E.body_note, "an empty list") end
    local commands = commands_of(body)

    while S.left(body) > 0 and not body.is_short do
      dissect_element(body, number, commands)
      number = number + 1
    end
    if commands.is_one_missing and not body.is_cut then
      body.item = body.root
      S.mark(body, E.body_note, "fewer elements than asked for")
    end
    if body.status == 0x01 and commands.is_each_answered and not commands.is_one_unknown and not body.is_cut then
      body.item = body.root
      S.mark(body, E.body_note, "the overall status is 1, but nothing in the list failed")
    end
  end
end

--- sis/services/parameter, sis/services/phase: SERCOS parameters and phases, and their twins of the product groups
-- (chapter 8)

do
  local CONTROL_RESERVED = K.PARAMETER_CONTROL_RESERVED
  local DATA_STATUS_UNDEFINED = 0xFEF0 -- fig. 8-44
  local NO_DRIVE, UNDEFINED_DEVICE = 0, 255

  -- A body of a parameter service being decoded is an `access`: body, general (the corresponding general service),
  -- element, is_last, device, ident (nil: unknown; in a reaction its command's), known.

  local function is_segment(access)
    return access.general == 0x11 or access.general == 0x1E
  end

  -- Of the services for segments, only 0x81 has sequential telegrams: the same command is repeated, and bit 2 marks
  -- the last reaction. Its pieces may end inside an element (IndraDrive, MPH-02).
  local function is_single(access)
    return is_segment(access) and access.body.service ~= 0x81
  end

  local function is_write(access)
    return access.general == 0x1E or access.general == 0x1F
  end

  local control_bits = {F.parameter_control_reserved, F.element, F.transmission}

  local function show_control(access)
    local body = access.body

    for _, bit_field in ipairs(control_bits) do
      add(body.item or body.tree, bit_field, body.tvb, body.offset - 1, 1)
    end
    if body.item then
      append_text(body.item,
        strformat(" (%s, %s)", N.elements[access.element], access.is_last and "last transmission" or "more follows"))
    end
  end

  -- Fig. 8-2: 1 to 254 are drives.
  local function check_device(body, device)
    if device == NO_DRIVE then append_text(body.item, " (the SERCOS master, or the drive that is addressed)") end
    if device == UNDEFINED_DEVICE then S.mark(body, E.body_note, "device address 255 is not defined") end
  end

  -- Only 0x10 and 0x1F have sequential telegrams, and ECODRIVE's 0x81.
  local function check_control(access, control)
    if band(control, CONTROL_RESERVED) ~= 0 then
      S.mark(access.body, E.body_note, "reserved bits of the parameter control")
    end
    if is_single(access) and not access.is_last then
      S.mark(access.body, E.body_note, "bit 2 is 0, but this service has no sequential telegrams")
    end
  end

  local function take_control(access)
    local body = access.body
    local control = S.take(body, F.parameter_control, 1)

    if not control then return false end
    access.element = band(rshift(control, 3), 7)
    access.is_last = band(control, K.TRANSMISSION) ~= 0
    if body.tree then show_control(access) end
    check_control(access, control)
    access.device = S.take(body, F.device, 1)
    if not access.device then return false end
    check_device(body, access.device)
    if body.request then
      body.request.element = access.element
      body.request.is_last = access.is_last or is_single(access)
    end
    S.request_device(body, access.device)
    return true
  end

  -- The parameter, and its element.
  local function say_parameter(access)
    local body, name = access.body, access.known.name

    S.say(body, name and " %s (%s)" or " %s", access.ident.text, name)
    if access.element == K.ELEMENT_IDENT and is_write(access) then
      S.say(body, ", data status")
    elseif access.element ~= K.ELEMENT_DATA then
      S.say(body, ", %s", string.lower(N.elements[access.element]))
    end
  end

  local function show_parameter(access)
    local body = access.body
    local at = body.offset

    body.item = S.add_ident(body.tree, body.tvb, {offset = at, length = 3, type_at = at, number_at = at + 1},
      access.ident, access.known)
  end

  -- Only 0 to 2 of the type byte are documented, and bits 3 to 7 are always 0; bit 15 tells S from P.
  local function check_ident(body, ident)
    if ident.type > 7 then
      S.mark(body, E.body_note, "reserved bits of the parameter's type")
    elseif ident.type > 2 then
      S.mark(body, E.body_note, "parameter type %d is not defined", ident.type)
    end
    if ident.type > 0 and ident.number >= 0x8000 then
      S.mark(body, E.body_note, "bit 15 is only defined for parameters of drives")
    end
  end

  local function take_parameter(access)
    local body = access.body

    if not S.needs(body, F.parameter, 3) then return false end
    local kind, low, high = byte(body.bytes, body.offset + 1, body.offset + 3)
    access.ident = S.ident(kind, low + high * 0x100)
    access.known = S.learned_known(body, access.ident, access.device)
    body.item = nil
    if body.tree then show_parameter(access) end
    body.offset = body.offset + 3
    say_parameter(access)
    check_ident(body, access.ident)
    if body.request then
      body.request.has_ident = true
      body.request.ident = access.ident
    end
    return true
  end

  -- 0x81 and 0x8E count offset and length of a segment in words, all others in bytes.
  local function counts_words(body)
    return body.service == 0x81 or body.service == 0x8E
  end

  local function check_announced(body, announced)
    local sent = S.left(body)

    if not body.is_cut and sent > 0 and sent ~= announced then
      S.mark(body, sent < announced and E.body_missing or E.body_unexpected, "%s bytes than announced",
        sent < announced and "fewer" or "more")
    end
  end

  -- The documents allow no more data in a telegram, some devices do.
  local function check_most(access, length)
    local most = is_write(access) and K.MOST_PARAMETER_WRITTEN or K.MOST_PARAMETER_READ

    if length > most then S.mark(access.body, E.body_note, "more than %d bytes", most) end
  end

  -- Offset and length count words in ECODRIVE's services, bytes in all others. Written data should have the declared
  -- length. A SYNAX may be asked for any (its page 2-30), and 0x81 has sequential telegrams.
  local function take_segment(access)
    local body = access.body
    local is_words = counts_words(body)
    local unit = is_words and "word" or "byte"
    local offset = S.take(body, F.list_offset, 2)

    if not offset then return false end
    append_text(body.item, " " .. unit .. plural(offset))
    local length = S.take(body, F.list_length, 2)
    if not length then return false end
    append_text(body.item, " " .. unit .. plural(length))
    if body.request then body.request.segment = offset * 0x10000 + length end
    S.say(body, ", %d %s%s at offset %d", length, unit, plural(length), offset)
    if is_single(access) and body.service ~= 0x91 then check_most(access, length * (is_words and 2 or 1)) end
    if is_write(access) then check_announced(body, length * (is_words and 2 or 1)) end
    return true
  end

  -- The reaction does not name the parameter; its command does.
  local function recall_parameter(access)
    local body = access.body

    if not body.asked or not body.asked.has_ident then return end
    access.ident = body.asked.ident
    access.known = S.learned_known(body, access.ident, access.device)
    if body.tree then S.add_ident(body.tree, body.tvb, {offset = 0, length = 0}, access.ident, access.known) end
    say_parameter(access)
  end

  local SHOWN_BYTES = 8

  -- A request for the data status may repeat the number of its parameter, or have no data (fig. 8-42).
  local function check_status_request(access, data)
    if access.ident and (data.length ~= 2 or S.little_endian(data.bytes, 1, 2) ~= access.ident.number) then
      S.mark(access.body, E.body_note, "a request for the data status carries its own ident number or nothing")
    end
  end

  -- A list may end before the requested length, and the device may have less room. SYNAX sends one element for any
  -- length (its page 2-30).
  local function check_segment(access, length)
    local body = access.body
    local asked = (body.asked and body.asked.segment or 0) % 0x10000 * (counts_words(body) and 2 or 1)

    if not is_segment(access) or not body.is_reaction or not access.ident or body.is_cut or length == asked
      or (body.service == 0x91 and length > 0) then
      return
    end
    body.item = body.root
    S.mark(body, E.body_note, length < asked and "fewer bytes than asked for" or "more bytes than asked for")
  end

  -- The data of an element: all of them, or a segment of a list.
  local function show_data(access, tree, data)
    local body, is_whole = access.body, not is_segment(access)

    if is_write(access) and access.element == K.ELEMENT_IDENT then
      add(tree, F.data, data.tvb, data.offset, data.length) -- not a value
      check_status_request(access, data)
      return
    end
    local exchange = body.record and body.record.exchange

    data.path = exchange and exchange.from.path
    local text = S.add_element(tree, body.pinfo, data, access.element, access.ident, access.known, is_whole)

    if text then
      S.say(body, " = %s", text)
    else
      S.say(body, ", %d byte%s%s", data.length, plural(data.length),
        data.length <= SHOWN_BYTES and ": " .. hex(data.bytes) or "")
    end
    body.data, body.text = is_whole and data or nil, text
    local misfit = not body.is_cut and S.element_misfit(data, access.element, access.known, is_whole)

    if misfit then
      body.item = body.root
      S.mark(body, E.body_note, "%s", misfit)
    end
    check_segment(access, data.length)
    if access.ident and is_whole and body.is_reaction then body.learn = S.station_learn end
  end

  local function show_piece(access, whole)
    local body = access.body
    local length = S.left(body)

    S.take_rest(body, F.data)
    S.say(body, ", %s of %d byte%s", access.is_last and "last piece" or "piece", length, plural(length))
    if not whole then return end
    length = whole.length
    local is_doubtful = S.is_doubtful(body)
    local tree = add_subtree(body.tree, whole.tvb, whole.offset, length, strformat("Data of all pieces%s, %d byte%s",
      is_doubtful and " if the transfer went on" or "", length, plural(length)))

    if is_doubtful then
      add(tree, F.data, whole.tvb, whole.offset, length)
    else
      show_data(access, tree, whole)
    end
  end

  local function take_data(access)
    local body = access.body

    if body.is_short then return end
    if not is_write(access) or not is_segment(access) then
      body.item = body.root
      check_most(access, S.left(body))
    end
    local data -- of this telegram, or of all pieces; nil if more pieces follow
    if is_single(access) or (not access.ident and access.is_last) then
      data = S.data(body)
    elseif access.ident then
      data = S.sequence_data(body, access.is_last)
    end
    if S.left(body) == 0 and not S.is_piece(body) then
      check_segment(access, 0)
      -- Only the last piece of a transfer may have no data (chapter 8.2). Of a segment the asked length decides.
      if access.ident and body.is_reaction and not is_segment(access) then S.needs(body, F.data, 1) end
      return
    end
    if not is_single(access) and (not data or S.is_piece(body)) then
      show_piece(access, data)
    else
      show_data(access, body.tree, data)
    end
    body.offset = body.end_
  end

  local function take_data_status(body)
    local status = S.take(body, F.data_status, 2)

    if not status then return end
    for _, bit_field in ipairs({F.data_status_invalid, F.data_status_impossible, F.data_status_not_executed,
      F.data_status_enabled, F.data_status_set}) do
      add_le(body.item or body.tree, bit_field, body.tvb, body.offset - 2, 2)
    end
    local text = strformat("command %s%s", N.data_states[band(status, 0x0F)] or "not defined",
      band(status, 0x0100) ~= 0 and ", operating data invalid" or "")
    append_text(body.item, " (" .. text .. ")")
    S.say(body, " = %s", text)
    if band(status, DATA_STATUS_UNDEFINED) ~= 0 or not N.data_states[band(status, 0x0F)] then
      S.mark(body, E.body_note, "undefined bits of the data status")
    end
  end

  -- The upper digit of a code selects the element, even if the code is undefined.
  local function take_parameter_error(body)
    S.take_error(body, N.errors_parameter, N.advice_parameter)
    local code = body.error
    local digit = rshift(code, 12)
    if digit >= 1 and digit < 8 and not N.errors_parameter[code] then
      append_text(body.item, ", element: " .. N.elements[digit])
    end
  end

  local function dissect_parameter_command(access)
    local body = access.body

    if not take_control(access) or not take_parameter(access) then return end
    if not is_write(access) and access.element <= K.ELEMENT_IDENT then -- chapter 8.1
      S.mark(body, E.body_note, "no document allows reading this element")
    end
    if is_segment(access) and not take_segment(access) then return end
    if not is_write(access) then return end
    if access.element ~= K.ELEMENT_DATA and access.element ~= K.ELEMENT_IDENT then
      S.mark(body, E.body_note, "only operating data and ident number can be written")
    end
    if S.left(body) == 0 and access.element ~= K.ELEMENT_IDENT then S.needs(body, F.data, 1) end
    take_data(access)
    if body.data and access.element == K.ELEMENT_DATA and body.request then
      body.request.written = body.data.bytes
    end
  end

  local function dissect_parameter_reaction(access)
    local body = access.body

    if not take_control(access) then return end
    recall_parameter(access)
    if body.status == 0x01 then
      take_parameter_error(body)
    elseif S.take_channel_error(body) then
      return
    elseif not is_write(access) then
      take_data(access)
    elseif access.element == K.ELEMENT_IDENT then -- chapters 8.6 and 8.7
      take_data_status(body)
    end
  end

  local function dissect_parameter(body)
    local access = {body = body, general = S.general_service(body.service)}

    if not body.is_reaction then
      dissect_parameter_command(access)
      return
    end
    dissect_parameter_reaction(access)
    if is_write(access) or body.status ~= 0 then
      S.note_answer(body, is_write(access))
    elseif access.is_last or is_single(access) then
      S.note_read(body)
    end
  end

  local HIGHEST_PHASE, OPERATING_PHASE = 4, 4

  local function take_phase(body)
    local phase = S.take(body, F.phase, 1)

    if not phase then return nil end
    local mode = N.phases[phase] and " (" .. N.phases[phase] .. ")" or ""
    append_text(body.item, mode)
    S.say(body, ": phase %d%s", phase, mode)
    if phase > HIGHEST_PHASE and body.telegram.is_good then -- in a damaged one it may be the damage
      S.mark(body, E.body_note, "phase %d is not defined", phase)
    end
    return phase
  end

  -- A switch ends with the poll that returns its phase or an error.
  local function learn_poll(body)
    local from = body.record.exchange.from

    if not from.phase_switch then return end
    local step = S.make_step(body.record, body.element)

    step.phase_switch = from.phase_switch
    step.is_switch_end = body.status ~= 0 or body.phase == from.phase_switch.to
    if step.is_switch_end then from.phase_switch = nil end
  end

  -- It begins when its command is acknowledged.
  local function learn_switch(body)
    local exchange = body.record.exchange
    local from = exchange.from

    if body.status ~= 0 or not body.asked then return end
    effects = effects + 1
    from.phase_switch = {
      command_in = exchange.command_in,
      begin = exchange.command_end,
      to = body.asked.phase or 0,
    }
    if from.phase_switch.to < OPERATING_PHASE then from.stream.idle_in = packet.number end
  end

  -- Adds what the first pass knows of the phase switch that a reaction polls.
  function S.show_switch(body)
    local step = S.step(body.record, body.element)
    local switch = step.phase_switch

    if not switch then return end
    append_text(add_generated(body.tree, F.phase_switch_in, body.tvb, switch.command_in),
      strformat(" (to phase %d)", switch.to))
    if not step.is_switch_end then
      S.say(body, ", switching to phase %d", switch.to)
      return
    end
    local words, taken = body.status == 0 and "reached" or "failed", T.elapsed(switch.begin, body.telegram.times.begin)

    if not S.is_measured(taken, body.telegram.times) then
      S.say(body, ", %s", words)
      return
    end
    local text = T.decimal_text(taken, 1e6, 3) .. " s"
    S.add_time(body.tree, F.phase_switch_time, body.tvb, taken, text)
    S.say(body, ", %s after %s", words, text)
  end

  local function dissect_phase_reaction(body)
    local is_switch = S.general_service(body.service) == 0x1D
    local is_accepted = is_switch and body.status == 0

    if body.status == 0x01 then
      S.take_rest(body, F.raw) -- not documented
      return
    elseif body.status > 0x02 and S.take_channel_error(body) then
      return
    end
    if is_accepted then S.say(body, ", accepted") end -- the documents differ whether the phase of now follows
    if is_accepted and body.asked and (body.asked.phase or 0) > HIGHEST_PHASE then
      S.mark(body, E.body_note, "a phase above 4 is refused with 0x8004, not accepted")
    end
    if not (is_accepted and S.left(body) == 0) then
      body.phase = take_phase(body)
      if not body.phase then return end
    end
    if body.status == 0x02 then S.take_error(body, N.errors_phase) end
    body.learn = is_switch and learn_switch or learn_poll
  end

  local function dissect_phase(body)
    if body.is_reaction then
      dissect_phase_reaction(body)
    elseif S.general_service(body.service) == 0x1D then
      local phase = take_phase(body)

      if phase and body.request then body.request.phase = phase end
    end
  end

  S.bodies[0x10], S.bodies[0x11] = dissect_parameter, dissect_parameter
  S.bodies[0x1E], S.bodies[0x1F] = dissect_parameter, dissect_parameter
  S.bodies[0x12], S.bodies[0x1D] = dissect_phase, dissect_phase
end

--- sis/exchange: what belongs together: command and reaction, repeats (chapter 2.4), and the same exchange
-- on two levels of a hierarchy (chapter 2.2), in the order of the capture. Frame numbers that are 0 in C are nil here.

do

  local lines, connections -- by key of the line, and of TCP
  local stream_count, bus_count

  at_init(function()
    lines, connections, stream_count, bus_count = {}, {}, 0, 0
  end)

  local function new_bus(is_connection)
    bus_count = bus_count + 1
    return {
      number = bus_count, -- of all, from 1
      is_connection = is_connection,
      damaged_count = 0, -- damaged telegrams, and what may have been one
      damaged_in = 0, -- the last of them
      lost_in = 0, -- the last loss of characters
      damage = {}, -- since its last good telegram: {is_there, command_in, head: of that command}
      open = {}, -- transfers under way, the oldest first (sis/sequence)
      last = {}, -- command of each master
      newest = nil, -- command of all masters
      streams = {},
      learned = {},
      devices = {}, -- types of each device, by stations and device
      types = {["type key"] = {}, firmware = {}}, -- devices of each type
      taught = {}, -- a new one after each thing learned
      told = S.told_new(),
      cycles = nil, -- sis/timing
    }
  end

  -- First pass: the line or connection of a packet.
  function S.exchange_bus(pinfo)
    local is_connection = packet.port_type ~= 0
    local known = is_connection and connections or lines
    local key = is_connection and S.connection(pinfo) or T.bus_key()

    known[key] = known[key] or new_bus(is_connection)
    return known[key]
  end

  local function new_stream(bus)
    local number = stream_count

    stream_count = number + 1
    local stream = {number = number, bus = bus, idle_in = 0} -- the last switch to a phase in which nothing moves

    -- For each direction: what its commands have in common (path), and the last of them (last, telegram, bytes).
    stream.from = {[0] = {stream = stream, transfers = {}}, {stream = stream, transfers = {}}}
    return stream
  end

  -- Two stations, including the route between them: a drive behind a router is not the router.
  local function stream_key(telegram)
    local sender, receiver = telegram.sender, telegram.receiver
    local key = sender < receiver and sender * 256 + receiver or receiver * 256 + sender

    if telegram.subaddress_count > 0 then key = strformat("%d ", key) .. sub(telegram.path, 2) end
    if telegram.is_before then key = "before " .. key end -- this file: no repeat, no time to what is in it
    return key
  end

  -- Of a command: the first one begins the stream.
  local function stream_of_command(bus, telegram)
    local key = stream_key(telegram)
    local stream = bus.streams[key]

    if not stream then
      stream = new_stream(bus)
      bus.streams[key] = stream
    end
    return stream
  end

  -- 0 or 1: the direction of a telegram's command in its stream.
  function S.direction(telegram)
    return telegram.sender > telegram.receiver and 1 or 0
  end

  local function note_damaged(bus, number, telegram)
    local is_legible = telegram and not telegram.is_reaction and #telegram.bytes >= telegram.body_offset

    bus.damaged_in = number
    bus.damaged_count = bus.damaged_count + 1
    bus.damage = {
      is_there = true,
      command_in = is_legible and number or nil,
      head = is_legible and sub(telegram.bytes, 1, telegram.body_offset) or nil,
    }
  end

  -- A telegram with a damaged length is not a telegram: the tap reports it as other characters.
  local function note_disturbance(bus, record)
    local seen = record.known

    if seen.lost_in > bus.lost_in then bus.lost_in = seen.lost_in end
    if seen.unframed_in > bus.damaged_in then note_damaged(bus, seen.unframed_in) end
  end

  -- The same bytes again, if the first had no good reaction; or with the same telegram number, whose reaction the
  -- slave has kept. Another step of a long read has the same bytes, too, but a reaction in between.
  local function find_repeat(exchange, from, bytes, telegram)
    local before = from.last

    if not before or from.bytes ~= bytes then return end
    from.same = before
    exchange.is_reaction_kept = telegram.number > 0
    exchange.is_kept_reaction_seen = exchange.is_reaction_kept and before.reaction_in ~= nil
    exchange.is_step_again = before.is_to_be_repeated
    if before.reaction_in and not exchange.is_reaction_kept then return end
    exchange.repeat_of = before.repeat_of or before.command_in
    exchange.first = before.first or before
  end

  -- A router's version of a waiting command belongs to it.
  local function find_route(exchange, telegram, bytes)
    local above = S.route_take(telegram, bytes)

    if above then
      exchange.routed_from = above.command_in
      above.forwarded = exchange
    end
  end

  -- Not to a group, and no token: the documents do not say whether those are answered.
  local function needs_reaction(command)
    return command.is_answered and command.service ~= K.TOKEN_PASSING
  end

  local function wait_since(end_, times)
    local wait = T.elapsed(end_, times.begin)

    return S.is_measured(wait, times) and wait or -1
  end

  -- A master sends its next command: was the one before answered, and how long did it wait (TwM, chapter 10.5)?
  local function follow_command(exchange, before, telegram)
    local from, command_before = exchange.from, before.from.telegram

    if needs_reaction(command_before) and not before.reaction_in then
      before.next_command_in = exchange.command_in
      before.is_reaction_damaged = from.stream.bus.damaged_in > before.command_in
      exchange.gave_up = before.command_in
      if S.is_counting then exchange.gave_up_station = byte(before.from.path) end
    end
    if exchange.repeat_of then
      exchange.wait = wait_since(from.last.command_end, telegram.times)
    elseif not command_before.is_answered then
      exchange.wait = wait_since(before.command_end, telegram.times)
    end
  end

  -- What the commands before it are to a command of this file.
  local function find_relations(exchange, bus, telegram, bytes)
    local before = bus.last[telegram.sender]

    find_route(exchange, telegram, bytes)
    if before then follow_command(exchange, before, telegram) end
    bus.last[telegram.sender] = exchange
    bus.newest = exchange
  end

  local function begin_exchange(bus, number, telegram)
    local stream, times = stream_of_command(bus, telegram), telegram.times
    local from = stream.from[S.direction(telegram)]
    local bytes, declared = telegram.bytes, telegram.declared
    local exchange = { -- with only the fields that most exchanges need: half of the memory
      from = from,
      command_in = number,
      command_end = times.end_,
      command_end_earliest = times.end_earliest,
      reaction_in = nil,
      request = nil,
    }

    if S.is_counting then exchange.command_begin = times.begin end
    if #bytes > declared then bytes = sub(bytes, 1, declared) end
    from.path, from.same = telegram.path, nil
    if needs_reaction(telegram) then find_repeat(exchange, from, bytes, telegram) end
    if not telegram.is_before then find_relations(exchange, bus, telegram, bytes) end
    if from.last then S.route_leave(from.last) end
    from.telegram = telegram
    from.bytes = bytes
    from.last = exchange
    if telegram.subaddress_count > 0 and not telegram.is_before then S.route_wait(exchange, telegram, bytes) end
    return exchange
  end

  -- Parameter control (without bit 2) and device address of a parameter service, as far as available.
  local function is_same_access(command, telegram)
    local body, reaction = telegram.body_offset, telegram.bytes -- in a reaction the status comes first

    if not S.has_control_byte(telegram.service) or body + 2 > #command or body + 3 > telegram.declared then
      return true
    end
    return band(bxor(byte(command, body + 1), byte(reaction, body + 2)), 0xFF - K.TRANSMISSION) == 0
      and byte(command, body + 2) == byte(reaction, body + 3)
  end

  -- The subservice, second byte of the useful data of a command, third of a reaction, where both have it.
  local function is_same_subservice(command, telegram)
    local body = telegram.body_offset

    if body + 2 > #command or body + 3 > telegram.declared then return true end
    return S.may_answer_subservice(telegram.service, byte(command, body + 2), byte(telegram.bytes, body + 3))
  end

  -- Whether a reaction fits the last command of a direction. A reaction keeps the command's addresses; a device may
  -- also swap sender and receiver.
  local function is_reaction_to(from, telegram)
    local command, body = from.telegram, telegram.body_offset
    local is_kept = command.sender == telegram.sender and command.receiver == telegram.receiver
    local is_swapped = command.sender == telegram.receiver and command.receiver == telegram.sender

    return command.service == telegram.service
      and command.subaddress_count == telegram.subaddress_count
      and command.has_number == telegram.has_number
      and (is_kept or is_swapped)
      and (body == K.STATIC_LENGTH or sub(from.bytes, 9, body) == sub(telegram.bytes, 9, body))
      and is_same_access(from.bytes, telegram)
      and is_same_subservice(from.bytes, telegram)
  end

  -- It was answered or the master went on, and a damaged telegram came since. That one may have been another command,
  -- so a reaction that comes now belongs to the damaged telegram. What needs no reaction, such as a token (chapter 9
  -- does not say), may have one only before the next command of any master.
  local function is_over(exchange)
    local bus = exchange.from.stream.bus
    local over_in = exchange.reaction_in or exchange.next_command_in

    if not needs_reaction(exchange.from.telegram) and not bus.is_connection and bus.newest ~= exchange then
      return true
    end
    return over_in and bus.damaged_in > over_in
  end

  local function answer(record, exchange, number, telegram)
    local stream = exchange.from.stream

    record.exchange = exchange
    if exchange.reaction_in then
      record.reaction_before = exchange.reaction_in
      return
    end
    exchange.reaction_in = number
    if stream.bus.is_connection then
      exchange.next_command_in = nil -- a master need not wait there
    end
    S.route_leave(exchange)
    if exchange.command_in ~= number and not telegram.is_before then -- nil where both are in one packet
      record.reaction_time = T.elapsed(exchange.command_end, telegram.times.begin)
    end
    if exchange.forwarded then record.routed_from = exchange.forwarded.reaction_in end
  end

  -- Chapter 2.4: point to point, a slave answers a damaged command, with 0xF1, 0xF2 or 0xF4; on a bus it is silent.
  local function is_answer_to_damage(bus, telegram)
    if not bus.damage.is_there or telegram.body_offset >= telegram.declared or not S.has_status(telegram.service) then
      return false
    end
    local status = byte(telegram.bytes, telegram.body_offset + 1)

    return status == 0xF1 or status == 0xF2 or status == 0xF4
  end

  -- Whether the damaged command has the same service and addresses.
  local function has_damaged_head(damage, telegram)
    local layout = K.CONTROL_SUBADDRESSES + K.CONTROL_NUMBER

    return damage.command_in and #damage.head == telegram.body_offset
      and band(bxor(byte(damage.head, 5), telegram.control), layout) == 0
      and sub(damage.head, 6) == sub(telegram.bytes, 6, telegram.body_offset)
  end

  -- Whether the command before went to the point-to-point address, and would fit but for that.
  local function is_own_number(bus, telegram)
    local before = bus.last[telegram.sender]

    return before and not before.reaction_in
      and S.receiver_kind(byte(before.from.path, -1)) == K.POINT_TO_POINT
      and S.receiver_kind(byte(telegram.path, -1)) == K.STATION
      and before.from.telegram.service == telegram.service
  end

  local function end_exchange(record, bus, number, telegram)
    local stream, kept = bus.streams[stream_key(telegram)], S.direction(telegram)

    for i = 0, 1 do
      local from = stream and stream.from[i == 0 and kept or 1 - kept]

      if from and from.last and is_reaction_to(from, telegram) then
        if not is_over(from.last) then
          answer(record, from.last, number, telegram)
          return
        end
        if needs_reaction(from.telegram) then
          bus.damaged_count = bus.damaged_count + 1 -- its contents are lost, as if it were damaged, too
        end
      end
    end
    if is_answer_to_damage(bus, telegram) then
      record.origin = "damaged"
    elseif is_own_number(bus, telegram) then
      record.origin = "own number"
    end
  end

  -- Finds the relations of a telegram. A damaged one may have been the reaction that a command waits for.
  function S.exchange_learn(record, bus, number, telegram)
    local tap = packet.record

    if tap then note_disturbance(bus, tap) end
    if not telegram.is_good then
      if not telegram.is_before then note_damaged(bus, number, telegram) end
      return
    end
    if not telegram.is_reaction then
      record.exchange = begin_exchange(bus, number, telegram)
    elseif is_answer_to_damage(bus, telegram) and has_damaged_head(bus.damage, telegram) then
      record.origin, record.damaged_in = "damaged", bus.damage.command_in
      bus.damaged_count = bus.damaged_count - 1 -- it was not executed, so its damage has cost nothing
    else
      end_exchange(record, bus, number, telegram)
    end
    bus.damage.is_there = bus.damage.is_there and telegram.is_before
  end

  local NO_STEP = {}

  -- What few services need of the first pass: that of a telegram (place 0), or an element of a list. `whose` is a
  -- record or an exchange.
  function S.step(whose, place)
    return whose.steps and whose.steps[place] or NO_STEP
  end

  function S.make_step(whose, place)
    whose.steps = whose.steps or {}
    whose.steps[place] = whose.steps[place] or {}
    return whose.steps[place]
  end

  -- Whether a reaction has its command's addresses swapped: then its sender really sent it.
  function S.is_swapped(record, telegram)
    local exchange = record.exchange

    return exchange and exchange.from ~= exchange.from.stream.from[S.direction(telegram)]
  end

  -- A duration that stands for no bytes, with a text as add_value() takes it.
  function S.add_time(tree, which, tvb, ns, ...)
    return set_generated(add_duration(tree, which, tvb, 0, 0, ns, ...))
  end

  -- The same as "12.345 ms". A clock that is set back makes none.
  function S.add_ms(tree, which, tvb, ns, is_longer)
    if ns >= 0 then S.add_time(tree, which, tvb, ns, T.ms_text, ns, is_longer) end
  end

  -- A time as a number of ms, rounded to three digits, for a column of the packet list. Hidden: the tree has the time
  -- already.
  function S.add_column_ms(tree, which, tvb, ns)
    if is_wanted(tree, which) then
      set_hidden(set_generated(add(tree, which, tvb, 0, 0, floor(ns / 1000 + 0.5) / 1000)))
    end
  end

  local function show_command(exchange, body)
    local tree, tvb, root = body.tree, body.tvb, body.root

    if tree then
      add_generated(tree, F.reaction_in, tvb, exchange.reaction_in)
      add_generated(tree, F.repeat_of, tvb, exchange.repeat_of)
      add_generated(tree, F.unanswered_before, tvb, exchange.gave_up)
      add_generated(tree, F.routed_from, tvb, exchange.routed_from)
      add_generated(tree, F.next_command_in, tvb, exchange.next_command_in)
    end
    if exchange.repeat_of then
      add_expert(root, E.command_repeat)
      body.marks = body.marks .. "  [repeat]"
    end
    if exchange.next_command_in then
      add_expert(root, E.command_unanswered, "No reaction before the next command"
        .. (exchange.is_reaction_damaged and "; a damaged telegram came between" or ""))
      body.marks = body.marks .. "  [no reaction]"
    end
  end

  local function show_origin(record, body)
    if record.origin == "damaged" then
      append_text(add_generated(body.tree, F.command_in, body.tvb, record.damaged_in), ", damaged")
      add_expert(body.root, E.reaction_to_damaged)
    elseif record.origin == "own number" then
      add_expert(body.root, E.reaction_unasked,
        "A command to 128 is answered with 128, not with the station's own number")
    else
      add_expert(body.root, E.reaction_unasked)
    end
  end

  local function show_reaction(record, body)
    local exchange = record.exchange
    local tree, tvb, root = body.tree, body.tvb, body.root

    if not exchange then
      show_origin(record, body)
      return
    end
    local command = add_generated(tree, F.command_in, tvb, exchange.command_in)
    add_generated(tree, F.routed_from, tvb, record.routed_from)
    add_generated(tree, F.answered_in, tvb, record.reaction_before)
    if record.reaction_before then
      add_expert(root, E.reaction_again)
    elseif record.reaction_time and not S.is_measured(record.reaction_time, body.telegram.times) then
      append_text(command, strformat(", %s: the reaction time is not known",
        record.reaction_time == 0 and "in the same read" or "whose end has a later time"))
    elseif record.reaction_time and tree then
      S.add_ms(tree, F.reaction_time, tvb, record.reaction_time)
      S.add_column_ms(tree, F.reaction_time_ms, tvb, record.reaction_time)
    end
  end

  -- Adds the known relations to the tree, and notes.
  function S.exchange_show(record, telegram, body)
    local exchange = record.exchange

    add_generated(body.tree, F.stream, body.tvb, exchange and exchange.from.stream.number)
    if telegram.is_reaction then
      show_reaction(record, body)
    elseif exchange then
      show_command(exchange, body)
    end
  end
end

--- sis/routes: commands through routers: which command on one level became which on the next (chapter 2.2).
--
-- A router drops the first address and sends the rest on. So a command that waits is kept by what the next router would
-- send: as many as there are, one look finds the one of which a router made another.

do
  -- The keys of waiting commands; {key, count: waiting commands, first, last: numbers of its commands}.
  local routes, route_count

  at_init(function() routes, route_count = {}, 0 end)

  -- The part that a router does not change, of a telegram from which it has dropped this many addresses: 0, or 1
  -- before it drops one. Two sections of a capture are two plants.
  local function make_key(telegram, bytes, dropped)
    local of_section = S.place()
    local number = telegram.has_number and 1 or 0

    return strformat("%d %d %d %d ", of_section, telegram.service, telegram.subaddress_count - dropped, number)
      .. sub(bytes, 7 + dropped)
  end

  local function new_route(key)
    routes[key] = {key = key, count = 0, first = 1, last = 0}
    route_count = route_count + 1
    return routes[key]
  end

  -- Drops the first entries that no longer wait.
  local function skip_left(route)
    while route.first <= route.last and route[route.first].route ~= route do
      route[route.first] = nil
      route.first = route.first + 1
    end
  end

  -- Makes a command with subaddresses wait for the next router's version.
  function S.route_wait(exchange, telegram, bytes)
    local key = make_key(telegram, bytes, 1)
    local route = routes[key] or new_route(key)

    skip_left(route)
    route.last = route.last + 1
    route[route.last] = exchange
    route.count = route.count + 1
    exchange.route = route
  end

  -- A command was answered, or its master has sent the next one: ends its wait, if any.
  function S.route_leave(exchange)
    local route = exchange.route

    if not route then return end
    exchange.route = nil
    route.count = route.count - 1
    if route.count == 0 then
      routes[route.key] = nil
      route_count = route_count - 1
    end
  end

  -- The oldest waiting command whose routed version this may be; ends its wait. nil: none.
  function S.route_take(telegram, bytes)
    local route = route_count > 0 and routes[make_key(telegram, bytes, 0)]

    if not route then return end
    skip_left(route)
    local oldest = route[route.first]

    S.route_leave(oldest)
    return oldest
  end
end

--- sis/pieces: data that do not fit into one packet, put together

do
  K.PIECES_OF_SIS = {all = F.sequence, piece = F.sequence_piece, count = F.sequence_count, length = F.sequence_length,
    whole_in = F.sequence_whole_in}
  local OF_SYNAX = {all = FX.synax_pieces, piece = FX.synax_pieces_piece, count = FX.synax_pieces_count,
    length = FX.synax_pieces_length, whole_in = FX.synax_pieces_whole_in}

  -- A transfer: {pieces = {frame, bytes or length}, whole_in, bytes: of the whole, full_in: frame of the first piece
  -- too many}. First pass: adds a piece.
  function S.add_piece(transfer, bytes, is_last)
    local pieces, all = transfer.pieces, {}

    if #pieces == K.MOST_PIECES then
      transfer.full_in = transfer.full_in or packet.number
      return
    end
    pieces[#pieces + 1] = {frame = packet.number, bytes = bytes}
    if not is_last then return end
    for i, piece in ipairs(pieces) do
      all[i], piece.length, piece.bytes = piece.bytes, #piece.bytes, nil
    end
    transfer.bytes, transfer.whole_in = concat(all), packet.number
  end

  local function show_piece(tree, tvb, which, piece, offset)
    local words

    if piece.length == 0 then
      words = strformat("Frame: %d (no data)", piece.frame)
    else
      words = strformat("Frame: %d, payload: %d-%d (%d byte%s)", piece.frame, offset, offset + piece.length - 1,
        piece.length, plural(piece.length))
    end
    set_generated(add(tree, which.piece, tvb, offset, piece.length, piece.frame, words))
  end

  -- As Wireshark's own reassembly shows it. `which` has its fields: all, piece, count, length.
  local function show_pieces(parent, data, pieces, which)
    local item, offset = add(parent, which.all, data.tvb, 0, data.tvb:len()), 0
    local tree = item or parent

    if item then
      item:set_text(strformat("%d %s (%d byte%s):", #pieces, #pieces == 1 and "Piece" or "Pieces", data.length,
        plural(data.length)))
    end
    for i, piece in ipairs(pieces) do -- one by one: so a line that is too long is cut like those of Wireshark
      append_text(item, strformat("%s #%d(%d)", i > 1 and "," or "", piece.frame, piece.length))
    end
    set_generated(item)
    for _, piece in ipairs(pieces) do
      show_piece(tree, data.tvb, which, piece, offset)
      offset = offset + piece.length
    end
    add_generated(tree, which.count, data.tvb, #pieces)
    add_generated(tree, which.length, data.tvb, data.length)
  end

  -- Shows what is known of the piece at `offset`, with the fields `which`. Returns the whole with its last piece, as
  -- S.data() does; its tvb only with a tree.
  function S.put_together(tree, tvb, offset, transfer, is_last, which)
    if not transfer.whole_in then return nil end
    if not is_last then
      set_generated(add(tree, which.whole_in, tvb, offset, 0, transfer.whole_in))
      return nil
    end
    local data = {offset = 0, length = #transfer.bytes, bytes = transfer.bytes}

    if tree then
      data.tvb = ByteArray.new(data.bytes, true):tvb("Data of all pieces")
      show_pieces(tree, data, transfer.pieces, which)
    end
    return data
  end

  -- The same for SYNAX: `tvb` is the piece. Returns the tvb of the whole.
  function S.put_next(tree, tvb, transfer, is_last)
    if transfer.full_in and packet.number >= transfer.full_in then add_expert(tree, EX.synax_pieces_too_many) end
    local data = S.put_together(tree, tvb, 0, transfer, is_last, OF_SYNAX)

    return data and data.tvb
  end
end

--- sis/sequence: sequential telegrams: data that do not fit into one are read or written in pieces
-- (chapters 8.2 and 8.7). Bit 2 of the parameter control says whether more follow; nothing says that a piece is the
-- first, or which one it is.

do

  local SERVICE_CHANNEL_BUSY = 0x8001 -- the command was not executed, and must be repeated
  local PARAMETER_OCCUPIED = 0x800C
  local CANCELLED = 0x800B -- another request had priority: the transfer has ended
  local TELEGRAM_ERROR = 0xF0 -- and above
  local INVALID_SEQUENTIAL_TELEGRAM = 0xF8
  local LENGTH_WORDS = 4 -- bytes of a list: actual and maximum length


  -- A transfer: {service, is_in_list: of elements of service 0x04, element, device, ident, segment, exchange: that
  -- began it, begun_in, last_in: the latest piece, damaged_count: of its bus, then, is_broken: a piece may be missing,
  -- and the pieces are no longer put together, pieces: {frame, length}, whole_in, bytes: of the whole, received: bytes,
  -- announced: bytes, by the length words of a list (nil: nothing was), length_words: as they stand, cancelled_in: a
  -- command since the latest piece, not confirmed yet, begun_after: the list of services that begins it behind a
  -- cancel, is_refused: with 0xF8, so that it begins anew or goes on, is_doubtful: a cancel was not confirmed, and
  -- nothing tells whether it began anew or went on, is_begun_anew}. A step keeps the one that it is a piece of.

  -- Useful data, or data reassembled from pieces: {tvb, offset, length, bytes}. A whole has its tvb only with a tree.
  function S.data(body)
    local left = S.left(body)

    return {
      tvb = body.tvb,
      offset = body.offset,
      length = left,
      bytes = sub(body.bytes, body.offset + 1, body.offset + left),
    }
  end

  -- An element of a list and a telegram are never steps of one transfer: between its telegrams, the service stays the
  -- same (0xF8, fig. 2-18).
  local function is_same_transfer(a, b)
    return a.service == b.service
      and a.is_in_list == b.is_in_list
      and a.element == b.element
      and a.ident == b.ident
      and a.device == b.device
      and a.segment == b.segment
  end

  -- nil if it is not under way.
  local function find_transfer(exchange, like)
    for _, transfer in ipairs(exchange.from.transfers) do
      if is_same_transfer(transfer, like) then
        return transfer
      end
    end
  end

  -- Whether the same data are under way in telegrams, if these are in a list, or the other way round.
  local function is_under_way_apart(exchange, like)
    like.is_in_list = not like.is_in_list
    local is_apart = find_transfer(exchange, like) ~= nil

    like.is_in_list = not like.is_in_list
    return is_apart
  end

  -- Puts another transfer in the place of this one; nil: none.
  local function replace(transfers, transfer, other)
    for place, open in ipairs(transfers) do
      if open == transfer then
        if other then transfers[place] = other else table.remove(transfers, place) end
        return
      end
    end
  end

  local function end_transfer(transfer)
    replace(transfer.exchange.from.transfers, transfer, nil)
    replace(transfer.exchange.from.stream.bus.open, transfer, nil)
  end

  local function note_end(body, transfer, reason)
    if transfer.is_refused then return end -- already reported
    local step = S.make_step(body.record, body.element)

    step.ended = step.ended or {}
    table.insert(step.ended, 1, {begun_in = transfer.begun_in, reason = reason})
  end

  local function end_with_note(body, transfer, reason)
    note_end(body, transfer, reason)
    end_transfer(transfer)
  end

  -- The place of a command in its list, 0 without a list.
  local function command_place(body)
    return body.is_reaction and (body.asked and body.asked.place or 0) or body.element
  end

  -- A step seen before: the same command again, or its reaction again.
  local function is_taken_before(body)
    local record, exchange = body.record, body.record.exchange

    if body.is_reaction then return record.reaction_before ~= nil or exchange.is_kept_reaction_seen end
    local same = exchange.is_step_again and exchange.from.same

    return exchange.repeat_of ~= nil or same and S.step(same, body.element).is_to_be_repeated
  end

  -- The transfer of the same step before; nil: none.
  local function transfer_before(body)
    local exchange = body.record.exchange
    local before = body.is_reaction and exchange or exchange.from.same

    return before and S.step(before, command_place(body)).transfer
  end

  -- Whether a piece may have been lost since the one before: lost characters; the damaged reaction to a command that
  -- was then repeated; or a damaged command with its damaged reaction. Not if the slave repeats the reaction that it
  -- has kept.
  local function is_piece_missing(body, transfer)
    local exchange = body.record.exchange
    local bus, enough = exchange.from.stream.bus, body.is_reaction and exchange.repeat_of and 1 or 2

    return bus.lost_in > transfer.last_in
      or not exchange.is_reaction_kept and bus.damaged_count - transfer.damaged_count >= enough
  end

  -- How many bytes a list is going to have, if this is its first piece and it has length words; nil: it does not say.
  local function announced_by(bytes)
    if #bytes < LENGTH_WORDS then return nil end
    local actual, maximum = S.little_endian(bytes, 1, 2), S.little_endian(bytes, 3, 2)

    if actual > maximum or actual + LENGTH_WORDS <= #bytes then return nil end
    return actual + LENGTH_WORDS
  end

  local function begin_transfer(body, like)
    local bytes = S.data(body).bytes

    return {
      service = like.service,
      is_in_list = like.is_in_list,
      exchange = like.exchange or body.record.exchange,
      element = like.element,
      device = like.device,
      ident = like.ident,
      segment = like.segment,
      begun_in = packet.number,
      last_in = packet.number,
      damaged_count = body.record.exchange.from.stream.bus.damaged_count,
      pieces = {},
      received = 0,
      announced = announced_by(bytes),
      length_words = sub(bytes, 1, LENGTH_WORDS),
    }
  end

  -- After 0xF8, or a cancel that was not confirmed, a transfer restarts with its length words, or continues. The
  -- announced length decides whether it can continue. If neither fits, pieces are missing.
  local function follow_break(transfer, body, is_last)
    local bytes, begun = S.data(body).bytes, transfer
    local received = transfer.received + #bytes

    if not transfer.announced then
      transfer.is_doubtful = true
    elseif #bytes >= LENGTH_WORDS and sub(bytes, 1, LENGTH_WORDS) == transfer.length_words then
      note_end(body, transfer, "cancelled")
      begun = begin_transfer(body, transfer)
      begun.is_begun_anew = true
    elseif is_last and received ~= transfer.announced or received > transfer.announced then
      begun = begin_transfer(body, transfer)
      begun.is_broken = true
      begun.is_begun_anew = transfer.is_begun_anew
    end
    begun.is_doubtful = transfer.is_doubtful
    begun.is_refused, begun.cancelled_in, begun.begun_after = nil, nil, transfer.begun_after
    replace(transfer.exchange.from.transfers, transfer, begun)
    replace(transfer.exchange.from.stream.bus.open, transfer, begun)
    return begun
  end

  -- Appends a transfer to the lists. Their length is limited, so the oldest may be dropped.
  local function open_transfer(body, like)
    local exchange = body.record.exchange
    local open = exchange.from.stream.bus.open

    if #open >= K.MOST_OPEN then end_with_note(body, open[1], "too many others have begun since") end
    local transfer = begin_transfer(body, like)

    table.insert(open, transfer)
    table.insert(exchange.from.transfers, transfer)
    return transfer
  end

  -- The transfer of a new piece; nil: it has none, because it is the only piece. Behind a cancel in the same list,
  -- written data begin anew.
  local function transfer_for(body, like, is_last)
    local exchange = body.record.exchange
    local transfer = find_transfer(exchange, like)
    local is_after = transfer and not body.is_reaction and transfer.cancelled_in == exchange.command_in

    if is_after then
      end_with_note(body, transfer, "cancelled")
    elseif transfer then
      local is_open = transfer.is_refused or transfer.cancelled_in

      return is_open and follow_break(transfer, body, is_last) or transfer
    end
    local is_apart = is_under_way_apart(exchange, like)

    if is_last and not is_apart then return nil end
    transfer = open_transfer(body, like)
    transfer.is_broken = is_apart or nil -- it may be a later piece of those
    transfer.begun_after = is_after and exchange.command_in or nil
    return transfer
  end

  -- A step again adds nothing to its transfer, which may be over.
  local function note_repeated(body, like)
    local transfer = find_transfer(body.record.exchange, like)
    local of = transfer or transfer_before(body)

    effects = effects + 1
    if not of then return end
    local step = S.make_step(body.record, body.element)

    step.transfer, step.is_piece_repeated = of, true
    step.is_piece_missing = transfer and transfer.is_broken
    step.is_doubtful = transfer and transfer.is_doubtful
  end

  -- The transfer of these data; decided once, in the order of the capture.
  local function place_piece(body, like, is_last)
    local exchange, frame = body.record.exchange, packet.number
    local transfer = transfer_for(body, like, is_last)

    effects = effects + 1
    if not transfer then return end
    S.make_step(exchange, command_place(body)).transfer = transfer
    if is_piece_missing(body, transfer)
      or transfer.received + S.left(body) > K.MOST_LIST + LENGTH_WORDS or #transfer.pieces == K.MOST_PIECES then
      transfer.is_broken = true
    end
    transfer.last_in = frame
    transfer.damaged_count = exchange.from.stream.bus.damaged_count
    transfer.received = transfer.received + S.left(body)
    local step = S.make_step(body.record, body.element)

    step.transfer = transfer
    step.is_piece_missing = transfer.is_broken
    step.is_doubtful = transfer.is_doubtful
    step.is_begun_anew = is_last and transfer.is_begun_anew
    if not transfer.is_broken then S.add_piece(transfer, S.data(body).bytes, is_last) end
    if is_last then end_transfer(transfer) end
  end

  -- The data of a restarted transfer, compared with its announced length.
  local function check_announced(body, bytes)
    if not S.step(body.record, body.element).is_begun_anew or #bytes < LENGTH_WORDS then return end
    local announced = S.little_endian(bytes, 1, 2) + LENGTH_WORDS

    if announced ~= #bytes then
      S.mark(body, E.body_note, "not as many bytes as the list announces")
    end
  end

  local function put_together(body, is_last)
    local step = S.step(body.record, body.element)

    body.item = body.root
    if step.is_piece_missing then
      S.mark(body, E.sequence_piece_missing, "a piece may be missing")
    end
    if step.is_doubtful then
      S.mark(body, E.body_note, "a cancel was not confirmed: it is not known whether the transfer goes on")
    end
    if step.is_piece_missing or step.is_piece_repeated then return nil end
    local data = S.put_together(body.tree, body.tvb, body.offset, step.transfer, is_last, K.PIECES_OF_SIS)

    if data then check_announced(body, data.bytes) end
    return data
  end

  -- Of an element of a list, or of a list as a whole.
  local function is_in_list(body)
    return body.element ~= 0 or body.service == K.LIST_SERVICE
  end

  -- What a command asks for, as a transfer. Without an ident it is like none.
  local function transfer_of(asked, is_listed)
    return {
      service = asked.service,
      is_in_list = is_listed,
      element = asked.element,
      device = asked.device or 0,
      ident = asked.ident,
      segment = asked.segment or 0,
    }
  end

  -- First pass: finds the transfer of these data. Most have nothing before or after them; only the last piece of one
  -- may be empty.
  local function learn_piece(body, is_last)
    local is_under_way = next(body.record.exchange.from.transfers) ~= nil
    local is_again = is_taken_before(body)

    if not is_again and is_last and not is_under_way then return end
    local like = transfer_of(body.is_reaction and body.asked or body.request, is_in_list(body))

    if S.left(body) == 0 and not find_transfer(body.record.exchange, like)
      and not is_under_way_apart(body.record.exchange, like) then
      return
    end
    if is_again then note_repeated(body, like) else place_piece(body, like, is_last) end
  end

  -- The data of a telegram that reads or writes a parameter, from body.offset to its end. `is_last` comes from its
  -- parameter control. Adds what is known of the transfer. Returns the whole data with the last piece, nil with
  -- another one, and the data themselves without a transfer.
  function S.sequence_data(body, is_last)
    if S.has_exchange(body) and not packet.visited then learn_piece(body, is_last) end
    if S.is_piece(body) then return put_together(body, is_last) end
    return is_last and S.data(body) or nil
  end

  -- Whether these data are a piece.
  function S.is_piece(body)
    return body.record ~= nil and S.step(body.record, body.element).transfer ~= nil
  end

  -- Whether it is not known if their transfer went on: then the whole may be none.
  function S.is_doubtful(body)
    return body.record ~= nil and S.step(body.record, body.element).is_doubtful
  end

  -- The command that is answered has to come again, or `is_so` is false.
  local function set_to_be_repeated(body, asked, is_so)
    local exchange = body.record.exchange

    if is_so then
      effects = effects + 1
      exchange.is_to_be_repeated = true
      S.make_step(exchange, asked.place or 0).is_to_be_repeated = true
    elseif exchange.steps then
      S.make_step(exchange, asked.place or 0).is_to_be_repeated = nil
    end
  end

  -- A list with an announced length may continue after 0xF8, or restart.
  local function refuse(body, transfer, asked)
    if body.status ~= INVALID_SEQUENTIAL_TELEGRAM or not transfer.announced then
      end_with_note(body, transfer, "refused")
      return
    end
    note_end(body, transfer, "refused")
    transfer.is_refused = true
    set_to_be_repeated(body, asked, true)
  end

  -- Whether a cancel reaches the station of another command of the same master: only the master that transfers
  -- cancels (chapter 4). 254 reaches all of one level, 255 lower levels, too (fig. 2-9). Where the members of a group
  -- are is not known.
  local function reaches(cancel, other)
    local command, path, routers = cancel.from.telegram, other.from.path, #cancel.from.path - 1

    if command.is_answered then return cancel.from == other.from end
    if command.is_before ~= other.from.telegram.is_before or command.sender ~= other.from.telegram.sender
      or #path <= routers or sub(path, 1, routers) ~= sub(cancel.from.path, 1, routers) then
      return false
    end
    return S.receiver_kind(byte(cancel.from.path, -1)) ~= K.LEVEL_BROADCAST or #path == routers + 1
  end

  -- Device and service may be missing; one byte alone may be either (chapter 4).
  local function is_cancelled(cancel, transfer)
    local is_device, is_service = transfer.device == cancel.device, transfer.service == cancel.subservice

    if cancel.has_device and cancel.has_subservice then
      return is_device and is_service
    end
    if cancel.is_ambiguous then
      return transfer.device == cancel.subservice or is_service
    end
    return true
  end

  -- Not executed, because the channel was busy or the telegram had an error (0xF1 to 0xF4): it will be repeated.
  local function is_to_be_repeated(body)
    local status = body.status

    return (status == 0x02 and body.error ~= CANCELLED)
      or body.error == SERVICE_CHANNEL_BUSY
      or body.error == PARAMETER_OCCUPIED
      or (status >= 0xF1 and status <= 0xF4)
  end

  -- Whether a transfer began behind this cancel, in the same list, or the one which that list repeats.
  local function is_begun_after(transfer, cancel, is_reaction)
    local list_in = (cancel.first or cancel).command_in

    return transfer.begun_after == list_in and not transfer.cancelled_in and (is_reaction or cancel.first)
  end

  -- A broadcast is not answered: each station obeys. A command to one station, or a group, leaves it open. After a
  -- telegram error it was not executed (chapter 2.3), nor while the channel was busy.
  local function cancel_transfer(body, transfer)
    local exchange = body.record.exchange
    local kind = S.receiver_kind(byte(exchange.from.path, -1))
    local is_broadcast = kind == K.LEVEL_BROADCAST or kind == K.GLOBAL_BROADCAST

    if is_begun_after(transfer, exchange, body.is_reaction) then
      transfer.is_broken = transfer.is_broken or body.status ~= 0 -- perhaps it did not begin there
    elseif body.is_reaction and body.status == 0 or not body.is_reaction and is_broadcast then
      end_with_note(body, transfer, "cancelled")
    elseif not body.is_reaction then
      transfer.cancelled_in = transfer.cancelled_in or exchange.command_in
    elseif (body.status >= TELEGRAM_ERROR or is_to_be_repeated(body))
      and transfer.cancelled_in == exchange.command_in then
      transfer.cancelled_in = nil
    end
  end

  local function watch_cancel(body, cancel)
    local exchange = body.record.exchange
    local open, place = exchange.from.stream.bus.open, 1

    effects = effects + 1
    while open[place] do
      local transfer = open[place]

      if reaches(exchange, transfer.exchange) and is_cancelled(cancel, transfer) then
        cancel_transfer(body, transfer)
      end
      if open[place] == transfer then place = place + 1 end
    end
  end

  -- Whether the list that is answered has a step of this transfer.
  local function is_step_in_list(body, transfer)
    local asked = body.element ~= 0 and body.record.exchange.request.list or nil

    while asked do
      if is_same_transfer(transfer_of(asked, true), transfer) then return true end
      asked = asked.next
    end
    return false
  end

  -- A device has one transfer at a time: a successful access to another parameter has ended the first. Those of one
  -- list go on together: the station executes all of it (chapter 7).
  local function end_others(body, like)
    local transfers, place = body.record.exchange.from.transfers, 1

    while transfers[place] do
      local other = transfers[place]

      if other.device == like.device and not is_same_transfer(other, like) and not is_step_in_list(body, other) then
        end_with_note(body, other, "another access to the device came between")
      else
        place = place + 1
      end
    end
  end

  local function watch_access(body, asked)
    local like = transfer_of(asked, is_in_list(body))
    local transfer = find_transfer(body.record.exchange, like)
    local is_repeat = is_to_be_repeated(body)

    set_to_be_repeated(body, asked, is_repeat)
    if body.status == 0 then
      end_others(body, like)
    elseif transfer and not is_repeat then
      refuse(body, transfer, asked)
    end
  end

  -- Nobody knows which command an element answers: it may have a piece of any transfer of its service.
  local function lose_piece(body)
    effects = effects + 1
    for _, transfer in ipairs(body.record.exchange.from.transfers) do
      if transfer.is_in_list and transfer.service == body.service then transfer.is_broken = true end
    end
  end

  -- The reaction to a service, or to a list that was refused with it.
  local function watch_reaction(body, asked)
    if asked.service == K.CANCEL_SERVICE then
      watch_cancel(body, asked)
    elseif S.has_control_byte(asked.service)
      and (body.status ~= 0 or next(body.record.exchange.from.transfers) or body.record.exchange.steps) then
      watch_access(body, asked)
    end
  end

  -- First pass: takes a body that may end transfers: cancelled, refused, or superseded by another parameter of the same
  -- device.
  function S.sequence_learn(body)
    local is_without_elements = body.status >= TELEGRAM_ERROR or body.error ~= 0

    if not body.is_reaction and body.service == K.CANCEL_SERVICE then watch_cancel(body, body.request) end
    if body.is_reaction and not body.asked and body.element ~= 0 then lose_piece(body) end
    if not body.is_reaction or not body.asked then return end
    if body.service ~= K.LIST_SERVICE then
      watch_reaction(body, body.asked)
    elseif is_without_elements then
      local asked = body.asked.list

      while asked do
        watch_reaction(body, asked)
        asked = asked.next
      end
    end
  end

  -- Adds the transfers that a body ended, the latest first, as they were noted.
  function S.sequence_show(body)
    local reason

    body.item = body.root
    for _, transfer in ipairs(S.step(body.record, body.element).ended or {}) do
      add_generated(body.tree, F.sequence_begun_in, body.tvb, transfer.begun_in)
      if transfer.reason ~= reason then
        S.mark(body, E.sequence_ended, "transfer ended unfinished: %s", transfer.reason)
      end
      reason = transfer.reason
    end
  end
end

--- parameters/parameters: how parameters are written, and what the built-in tables say of them. What the bus
-- says of them is learned below. Lua has no tables that the user edits, but it reads the file that Wireshark keeps for
-- the plugin's.

-- Elements of a parameter, bits 3 to 5 of the parameter control (fig. 8-1).
K.ELEMENT_IDENT = 1
K.ELEMENT_NAME = 2
K.ELEMENT_ATTRIBUTE = 3
K.ELEMENT_UNIT = 4
K.ELEMENT_MINIMUM = 5
K.ELEMENT_MAXIMUM = 6
K.ELEMENT_DATA = 7

-- The source of a name, a unit or an attribute, in words.
K.FROM_BUS = "learned from the bus"
K.FROM_TABLE = "from the table SIS parameters"
K.BUILT_IN = "built in"
K.FROM_STANDARD = "from Wireshark's SERCOS III table"

do
  local BIT_15 = 0x8000
  local SET_SIZE = 0x1000 -- the number word has a number of 12 bits, and a parameter set of 3
  local MAX_SET = 7

  local letters = {[0] = "S", "A", "C"} -- by type, with bit 15 clear

  local types = {S = 0, P = 0, A = 1, C = 2}

  -- Names of set 0, and the parameter whose unit is said. No P parameters: what these are depends on the device. No S
  -- parameters: their names are above.
  local built_in = {{"A", N.parameters_a, 4, "deg"}, {"C", N.parameters_c, 1, "ms"}}

  -- "S-0-0044", "P-2-0012", "A-0-0004", "C-0-0066", "type3-0-0066", "S-0-0390.0.136".
  local function ident_text(kind, word, structure)
    local letter = kind == 0 and word >= BIT_15 and "P" or letters[kind] or "type" .. strformat("%d", kind)

    return strformat("%s-%d-%04d%s%s", letter, band(rshift(word, 12), MAX_SET), word % SET_SIZE,
      kind > 0 and word >= BIT_15 and " with bit 15" or "",
      structure > 0 and strformat(".%d.%d", rshift(structure, 8), structure % 256) or "")
  end

  local idents -- by key: the same ident is the same table

  at_init(function() idents = {} end)

  -- Of a type byte and a number word (fig. 8-3), and of the structure that an ident of four bytes has.
  local function ident_key(kind, word, structure)
    return structure * 0x1000000 + kind * 0x10000 + word
  end

  -- An ident: {type, number, key, text: as it is written}. The structure is its instance * 256 + its element.
  function S.ident(kind, word, structure)
    structure = structure or 0
    local key = ident_key(kind, word, structure)

    idents[key] = idents[key] or {type = kind, number = word, key = key, text = ident_text(kind, word, structure)}
    return idents[key]
  end

  -- The ident of such a text, of the first four kinds, and the text behind it; nil: none is there.
  function S.ident_parse(text)
    local letter, set, number, rest = match(text, "^([SPAC])%-([0-7])%-(%d%d%d%d)(.*)$")

    number = tonumber(number)
    if not number or number >= SET_SIZE or match(rest, "^%d") then return nil end
    local instance, element, after = match(rest, "^%.(%d+)%.(%d+)(.*)$")
    local structure, word = 0, tonumber(set) * SET_SIZE + number

    if sub(rest, 1, 1) == "." then
      instance, element = tonumber(instance), tonumber(element)
      if not instance or instance > 255 or element > 255 then return nil end
      structure, rest = instance * 256 + element, after
    end
    return S.ident(types[letter], letter == "P" and BIT_15 + word or word, structure), rest
  end

  local by_key = {}

  for number, name in pairs(N.s_names) do
    by_key[ident_key(types.S, number, 0)] = {name = name, name_from = K.FROM_STANDARD}
  end
  for _, each in ipairs(built_in) do
    for number, name in pairs(each[2]) do
      local unit = number == each[3] and each[4] or nil

      by_key[ident_key(types[each[1]], number, 0)] = {
        name = name,
        name_from = K.BUILT_IN,
        unit = unit,
        unit_from = unit and K.BUILT_IN,
      }
    end
  end

  local nothing = {}
  local by_user -- by the stations to a device ("": every station) and key

  -- "0044", "2-0012" or "0390.0.136" with its letter; nil: it is no ident.
  local function parse_number(letter, text)
    local set, number, structure = match(text, "^([0-7])%-(%d+)(.*)$")

    if not set then
      set, number, structure = "0", match(text, "^(%d+)(.*)$")
    end
    if not types[letter] or not number then return nil end
    local ident, rest = S.ident_parse(strformat("%s-%s-%04d%s", letter, set, tonumber(number), structure))

    return rest == "" and ident or nil
  end

  -- "3" or "3/2/8" as bytes; nil: it is no path.
  local function parse_station(text)
    local path = ""

    if text == "" then return "" end
    for station in string.gmatch(text .. "/", "([^/]*)/") do
      local address = match(station, "^%d+$") and tonumber(station)

      if not address or address > 255 or #path == 8 then return nil end
      path = path .. char(address)
    end
    return path
  end

  local function of_user(path, key)
    return by_user[path] and by_user[path][key]
  end

  local function add_row(ident, path, cells)
    local known = {}

    for name, value in pairs(of_user(path, ident.key) or of_user("", ident.key) or by_key[ident.key] or nothing) do
      known[name] = value
    end
    local named = {name = cells[3], unit = cells[4], minimum = cells[6], maximum = cells[7], bits = cells[9]}

    for name, cell in pairs(named) do
      if cell ~= "" then known[name], known[name .. "_from"] = cell, K.FROM_TABLE end
    end
    local attribute = tonumber((gsub(cells[5], "^0x", "")), 16)

    if attribute and attribute > 0 then known.attribute, known.attribute_from = attribute, K.FROM_TABLE end
    by_user[path] = by_user[path] or {}
    by_user[path][ident.key] = known
  end

  -- The cells of a line of the file: "S","0036","Velocity command value","rpm","0x04220001".
  local function cells_of(line)
    local cells = {}

    for cell in string.gmatch(line, '"([^"]*)"') do
      cells[#cells + 1] = gsub(cell, "\\x(%x%x)", function(digits) return char(tonumber(digits, 16)) end)
    end
    for i = #cells + 1, 9 do cells[i] = "" end
    return cells
  end

  -- The profile is not known here: the file of the profile Default, else that of the profile SIS.
  -- The rows of every station, then those of one, which complete the former.
  local function read_table()
    local file = io.open(Dir.personal_config_path("sis_parameters"))
      or io.open(Dir.personal_config_path("profiles/SIS/sis_parameters"))
    local of_one = {}

    by_user = {}
    if not file then return end
    for line in file:lines() do
      local cells = cells_of(match(line, '^"[^\r]*') or "")
      local ident, path = parse_number(cells[1], cells[2]), parse_station(cells[8])

      if ident and path == "" then
        add_row(ident, path, cells)
      elseif ident and path then
        of_one[#of_one + 1] = {ident, path, cells}
      end
    end
    file:close()
    for _, row in ipairs(of_one) do add_row(unpack(row)) end
  end

  at_init(read_table)

  -- What the tables say of a parameter of a device behind stations; without these, of every station.
  function S.known_from_tables(ident, path)
    return path and of_user(path, ident.key) or of_user("", ident.key) or by_key[ident.key] or nothing
  end
end

--- parameters/learned: what the bus itself has said of its parameters. It is learned in the first pass; every
-- command keeps what was known when it was sent, so that all passes show the same.

do
  -- What is known of a parameter: {name, unit, attribute, minimum, maximum}, nil if unknown, each with its source as
  -- name_from and so on. Never changed once made: new knowledge makes a new one.

  local DEVICE = 2 ^ 40 -- above the key of an ident

  -- What the bus has said about a parameter of a device behind a station, perhaps through routers.
  local function find(bus, path, ident, device)
    local of_station = bus.learned[path]

    return of_station and of_station[device * DEVICE + ident.key]
  end

  local function look_up(body, ident, device)
    local exchange = body.record and body.record.exchange

    return exchange and find(exchange.from.stream.bus, exchange.from.path, ident, device)
  end

  local IDENTITIES = {"type key", "firmware"}

  -- First pass: a device has told its type; two devices that say the same have the same parameters.
  function S.learned_identity(bus, path, device, what, text)
    local devices, types = bus.devices, bus.types[what]
    local id = path .. "/" .. char(device)

    devices[id] = devices[id] or {}
    types[text] = types[text] or {}
    if devices[id][what] == types[text] then return end
    devices[id][what] = types[text]
    if #types[text] < K.MOST_TWINS then
      table.insert(types[text], {id = id, path = path, device = device})
    end
    bus.taught = {}
  end

  -- First pass: a good reaction has told the type of its device, as body.text.
  function S.station_identify(body, what)
    local from = body.record.exchange.from

    if not body.asked or body.is_cut or not body.text then return end
    effects = effects + 1
    S.learned_identity(from.stream.bus, from.path, body.asked.device, what, body.text)
  end

  -- What a device of the same type said of its parameter: {known, source in words}.
  local function find_twin(body, ident, device)
    local exchange = body.record and body.record.exchange
    local bus, path = exchange and exchange.from.stream.bus, exchange and exchange.from.path
    local id = exchange and path .. "/" .. char(device)

    for _, what in ipairs(IDENTITIES) do
      local types = bus and bus.devices[id] and bus.devices[id][what]

      for _, twin in ipairs(types or {}) do
        local known = find(bus, twin.path, ident, twin.device)

        if known and twin.id ~= id and bus.devices[twin.id][what] == types then
          return {known, strformat("learned from station %s, device %d, which has the same type",
            concat({byte(twin.path, 1, -1)}, "/"), twin.device)}
        end
      end
    end
  end

  local PARTS = {"name", "unit", "minimum", "maximum", "attribute"}

  -- With what a twin heard on the bus; the bus itself and the user's table go before it.
  local function with_twin(known, twin)
    if not twin then return known end
    local both = {}

    for name, value in pairs(known) do both[name] = value end
    for _, part in ipairs(PARTS) do
      local from = part .. "_from"

      if twin[1][from] == K.FROM_BUS and known[from] ~= K.FROM_BUS and known[from] ~= K.FROM_TABLE then
        both[part], both[from] = twin[1][part], twin[2]
      end
    end
    return both
  end

  -- What is known of a parameter of a device at this telegram: from the bus, else built in.
  function S.learned_known(body, ident, device)
    local found, exchange = body.asked, body.record and body.record.exchange

    if not found then
      found = {known = look_up(body, ident, device), twin = find_twin(body, ident, device)}
    end
    if body.request then body.request.known, body.request.twin = found.known, found.twin end
    return with_twin(found.known or S.known_from_tables(ident, exchange and exchange.from.path), found.twin)
  end

  -- Later passes: adds to what was known of a parameter what the bus has said of it only afterwards.
  function S.learned_complete(body, ident, device, known)
    local later = packet.visited and look_up(body, ident, device)

    if not later then return known end
    return {attribute = known.attribute or later.first_attribute, name = known.name or later.name,
      unit = known.unit or later.unit, minimum = known.minimum, maximum = known.maximum}
  end

  -- The same of a bus and the stations to the device: for what was told before.
  function S.learned_of(bus, path, ident, device)
    return find(bus, path, ident, device) or S.known_from_tables(ident, path)
  end

  -- First pass: takes over what an element says.
  function S.learned_add(bus, path, ident, device, what, value)
    local before = S.learned_of(bus, path, ident, device)
    local source = what .. "_from"

    if before[what] == value and before[source] == K.FROM_BUS then return end
    local known, learned = {}, bus.learned

    for name, old in pairs(before) do
      known[name] = old
    end
    if what == "attribute" and before.attribute_from ~= K.FROM_BUS then known.first_attribute = value end
    known[what], known[source] = value, K.FROM_BUS
    learned[path] = learned[path] or {}
    learned[path][device * DEVICE + ident.key] = known
    bus.taught = {}
  end

  -- What each element says: its field of what is known, and its value, nil if it is not valid.
  local readers = {
    [K.ELEMENT_NAME] = function(data)
      local name = S.element_text(data)

      return "name", name ~= "" and name or nil -- no name at all; an empty unit says that there is none
    end,
    [K.ELEMENT_UNIT] = function(data)
      return "unit", S.element_text(data)
    end,
    [K.ELEMENT_ATTRIBUTE] = function(data)
      return "attribute", data.length == 4 and S.little_endian(data.bytes, 1, 4) or nil
    end,
    [K.ELEMENT_MINIMUM] = function(_, shown)
      return "minimum", shown
    end,
    [K.ELEMENT_MAXIMUM] = function(_, shown)
      return "maximum", shown
    end,
  }

  -- First pass: a reaction has brought an element of the parameter that was asked for.
  function S.station_learn(body)
    local asked, from = body.asked, body.record.exchange.from
    local read = readers[asked.element]

    if not read then return end
    effects = effects + 1
    local what, value = read(body.data, body.text)

    if value ~= nil then S.learned_add(from.stream.bus, from.path, asked.ident, asked.device, what, value) end
  end
end

--- parameters/ident: a parameter in the tree: its ident bit by bit (fig. 8-3), and what is known of it

do
  local known_parts = {} -- {its field, its name, the name of where it is from}

  for _, part in ipairs({"name", "unit", "minimum", "maximum"}) do
    known_parts[#known_parts + 1] = {F["parameter_" .. part], part, part .. "_from"}
  end

  -- Adds sis.parameter, the parts of the ident, name, unit and limits. Returns its item. `place` is its place: offset
  -- and length (0: the command has it), type_at, number_at, is_big: the number word.
  function S.add_ident(tree, tvb, place, ident, known)
    local item = add(tree, F.parameter, tvb, place.offset, place.length, ident.text)
    local add_bits, subtree = place.is_big and add or add_le, item or tree

    if known.name then append_text(item, " (" .. known.name .. ")") end
    if place.length > 0 then
      if place.type_at then add(subtree, F.parameter_type, tvb, place.type_at, 1) end
      if ident.type == 0 then add_bits(subtree, F.parameter_product_specific, tvb, place.number_at, 2) end
      add_bits(subtree, F.parameter_set, tvb, place.number_at, 2)
      add_bits(subtree, F.parameter_number, tvb, place.number_at, 2)
    else
      set_generated(item)
    end
    for _, part in ipairs(known_parts) do
      local made = add_generated(subtree, part[1], tvb, known[part[2]])

      if made then append_text(made, " (" .. known[part[3]] .. ")") end
    end
    return item
  end
end

--- parameters/values: the elements of a parameter: attribute bit by bit, values scaled and with their unit, lists
-- element by element. SIS says nothing of all this; it is SERCOS, IEC 61491.

do
  local ATTRIBUTE_SIZE = 4
  local LIST_HEADER = 4 -- actual and maximum length, two bytes each

  local BINARY, UNSIGNED, SIGNED = K.FORMAT_BINARY, K.FORMAT_UNSIGNED, K.FORMAT_SIGNED
  local HEXADECIMAL, TEXT, IDENT, FLOATING = K.FORMAT_HEXADECIMAL, K.FORMAT_TEXT, K.FORMAT_IDENT, K.FORMAT_FLOATING
  local TIME = K.FORMAT_TIME

  local requests = {[0] = "clear", [1] = "interrupt", [3] = "set and enable"}

  -- `size` bits of a number from bit `first` on; `bit` of Lua is signed.
  local function bits(number, first, size)
    return floor(number / 2 ^ first) % 2 ^ size
  end

  local sizes = {[0] = 0, 2, 4, 8, 1, 2, 4, 8} -- of a value, by the code of its length

  -- How to read the elements of some data, made from an attribute; nil for undefined length codes. The unit is nil if
  -- there is none or it is unknown.
  local function read_layout(known)
    local attribute = known.attribute
    local code = attribute and bits(attribute, 16, 3)

    if not code or sizes[code] == 0 then return nil end
    return {
      size = sizes[code], -- of one value: 1, 2, 4 or 8 bytes
      is_list = code >= 4,
      is_command = bits(attribute, 19, 1) == 1,
      format = bits(attribute, 20, 3),
      decimals = bits(attribute, 24, 4),
      factor = max(bits(attribute, 0, 16), 1),
      unit = known.unit,
      bits = known.bits,
    }
  end

  -- `size` bytes from the one at `at`, which counts from 1: up to 4, as a double has no more than 53 bits.
  function S.little_endian(bytes, at, size)
    local value = 0

    for i = at + size - 1, at, -1 do
      value = value * 256 + byte(bytes, i)
    end
    return value
  end

  -- With a point in every locale: people filter for this text.
  local function double_text(digits, value)
    return (string.gsub(strformat("%." .. digits .. "g", value), "[^%w+-]+", "."))
  end

  -- The number that such a text shows, or nil. Lua reads numbers as the locale writes them.
  function S.shown_number(text)
    local point = match(strformat("%.1f", 0.5), "%D+")

    return text and tonumber((string.gsub(text, "%.", point)))
  end

  -- Digits of a whole number with a point before the last ones.
  local function point_text(digits, decimals)
    digits = rep("0", decimals + 1 - #digits) .. digits
    return decimals == 0 and digits or sub(digits, 1, -decimals - 1) .. "." .. sub(digits, -decimals)
  end

  -- Fixed point: exact to the decimal places. `magnitude` is a number, or an UInt64 for 8 bytes.
  local function decimal_text(magnitude, sign, layout)
    local factor, decimals = layout.factor, layout.decimals

    if layout.size < 8 then
      return sign .. point_text(strformat("%.0f", magnitude * factor), decimals)
    end
    if magnitude <= UInt64.max() / UInt64.new(factor) then
      return sign .. point_text(tostring(magnitude * UInt64.new(factor)), decimals)
    end
    return sign .. double_text(17, magnitude:tonumber() * factor / 10 ^ decimals)
  end

  -- A whole number of 8 bytes, and the number that gives 0 together with it.
  local function get_uint64(bytes, at)
    return UInt64.new(S.little_endian(bytes, at, 4), S.little_endian(bytes, at + 4, 4))
  end

  local function negate_uint64(bytes, at)
    local low, high = S.little_endian(bytes, at, 4), S.little_endian(bytes, at + 4, 4)

    return UInt64.new((2 ^ 32 - low) % 2 ^ 32, (2 ^ 32 - high - (low == 0 and 0 or 1)) % 2 ^ 32)
  end

  local function unsigned_text(bytes, at, layout)
    local size = layout.size

    return decimal_text(size == 8 and get_uint64(bytes, at) or S.little_endian(bytes, at, size), "", layout)
  end

  local function signed_text(bytes, at, layout)
    local size = layout.size

    if byte(bytes, at + size - 1) < 0x80 then return unsigned_text(bytes, at, layout) end
    if size == 8 then return decimal_text(negate_uint64(bytes, at), "-", layout) end
    return decimal_text(2 ^ (8 * size) - S.little_endian(bytes, at, size), "-", layout)
  end

  local function float_text(bytes, at, layout)
    if layout.size == 8 then return double_text(15, (Struct.unpack("<d", bytes, at))) end
    return double_text(7, (Struct.unpack("<f", bytes, at)))
  end

  local function nibble_text(nibble)
    return strformat("%d%d%d%d", bits(nibble, 3, 1), bits(nibble, 2, 1), bits(nibble, 1, 1), nibble % 2)
  end

  local function binary_text(bytes, at, layout)
    local nibbles = {}

    for i = at + layout.size - 1, at, -1 do
      local value = byte(bytes, i)

      nibbles[#nibbles + 1] = nibble_text(rshift(value, 4))
      nibbles[#nibbles + 1] = nibble_text(value % 16)
    end
    return "0b" .. concat(nibbles, " ")
  end

  local function hexadecimal_text(bytes, at, layout)
    local digits = {}

    for i = at + layout.size - 1, at, -1 do
      digits[#digits + 1] = strformat("%02X", byte(bytes, i))
    end
    return "0x" .. concat(digits)
  end

  -- An ident of two bytes, or of four: two of its structure in the upper half. Nil: it is something else.
  local function read_ident(bytes, at, layout)
    local size = layout.size

    if layout.format ~= IDENT or (size ~= 2 and size ~= 4) then return nil end
    return S.ident(0, S.little_endian(bytes, at, 2), size == 4 and S.little_endian(bytes, at + 2, 2) or 0)
  end

  local function ident_text(bytes, at, layout)
    local ident = read_ident(bytes, at, layout)

    return ident and ident.text or hexadecimal_text(bytes, at, layout)
  end

  -- Four bytes of seconds since 1970 (UTC), then four of nanoseconds, as Rexroth's MLPI describes the attribute
  -- (mlpiParameterLib.h).
  local function time_text(bytes, at, layout)
    local seconds, ns = S.little_endian(bytes, at, 4), S.little_endian(bytes, at + 4, 4)

    if ns >= 1000000000 then return hexadecimal_text(bytes, at, layout) end
    return os.date("!%Y-%m-%d %H:%M:%S", seconds) .. strformat(".%09d", ns)
  end

  -- For each format: how to write a number without its unit, and how many bytes it can have.
  local writers = {
    [BINARY] = {write = binary_text, least = 1, most = 8},
    [UNSIGNED] = {write = unsigned_text, least = 1, most = 8},
    [SIGNED] = {write = signed_text, least = 1, most = 8},
    [HEXADECIMAL] = {write = hexadecimal_text, least = 1, most = 8},
    [TEXT] = {write = hexadecimal_text, least = 1, most = 1},
    [IDENT] = {write = ident_text, least = 2, most = 4},
    [FLOATING] = {write = float_text, least = 4, most = 8},
    [TIME] = {write = time_text, least = 8, most = 8},
  }

  local function is_described(layout)
    local writer = writers[layout.format]

    return layout.size >= writer.least and layout.size <= writer.most
  end

  -- Of the value at `at`, which counts from 1; in hexadecimal if no document describes how to write it.
  local function value_text(bytes, at, layout)
    local format, unit = layout.format, layout.unit
    local number = (is_described(layout) and writers[format].write or hexadecimal_text)(bytes, at, layout)
    local request = layout.is_command and requests[S.little_endian(bytes, at, layout.size)]

    if request then return number .. " (" .. request .. ")" end
    if not unit or unit == "" or format == BINARY or format == IDENT or format == HEXADECIMAL or format == TIME then
      return number
    end
    return number .. " " .. unit
  end

  -- A number in the byte order of the transport: that of SIS, or `data.is_big`.
  local function get_number(data, at, size)
    if not data.is_big then return S.little_endian(data.bytes, at, size) end
    return S.little_endian(string.reverse(sub(data.bytes, at, at + size - 1)), 1, size)
  end

  -- Bytes with all elements after the length words in the byte order of SIS.
  local function ordered(data, header, size)
    if not data.is_big then return data.bytes end
    return sub(data.bytes, 1, header) .. gsub(sub(data.bytes, header + 1), rep(".", size), string.reverse)
  end

  -- The two length words of a SERCOS list, if they are there: SIS may not carry them.
  local function list_header_size(data)
    if data.length < LIST_HEADER then return 0 end
    local actual, maximum = get_number(data, 1, 2), get_number(data, 3, 2)

    return actual + LIST_HEADER == data.length and actual <= maximum and LIST_HEADER or 0
  end

  -- A name or a unit, without the two length words at the beginning of a list.
  function S.element_text(data)
    return S.text(sub(data.bytes, list_header_size(data) + 1))
  end

  -- Returns the size of the length words, 0 if there are none.
  local function add_list_header(tree, data, is_whole)
    local size = is_whole and list_header_size(data) or 0

    if size > 0 then
      local add_word = data.is_big and add or add_le

      add_word(tree, F.list_actual, data.tvb, data.offset, 2)
      add_word(tree, F.list_maximum, data.tvb, data.offset + 2, 2)
    end
    return size
  end

  local function add_text(tree, which, data, is_whole)
    local header = add_list_header(tree, data, is_whole)
    local text = S.text(sub(data.bytes, header + 1))

    add(tree, which, data.tvb, data.offset + header, data.length - header, text)
    return '"' .. text .. '"'
  end

  -- From the highest bit to the lowest. The texts of set bits, or of all bits with words, also follow the attribute.
  local attribute_bits = {
    {field = F.attribute_protected_4, first = 30, words = {[1] = "Write-protected in phase 4"}},
    {field = F.attribute_protected_3, first = 29, words = {[1] = "Write-protected in phase 3"}},
    {field = F.attribute_protected_2, first = 28, words = {[1] = "Write-protected in phase 2"}},
    {field = F.attribute_decimals},
    {field = F.attribute_format, first = 20, size = 3, name = "Format: ", words = N.attribute_formats},
    {field = F.attribute_command, first = 19, words = {[1] = "Procedure command"}},
    {field = F.attribute_length, first = 16, size = 3, name = "Length: ", words = N.attribute_lengths},
    {field = F.attribute_factor},
  }

  local function show_attribute(tree, data, attribute)
    local add_bits = data.is_big and add or add_le
    local item = add_bits(tree, F.attribute, data.tvb, data.offset, ATTRIBUTE_SIZE)

    for _, part in ipairs(attribute_bits) do
      local word = part.words and part.words[bits(attribute, part.first, part.size or 1)]

      add_bits(item or tree, part.field, data.tvb, data.offset, ATTRIBUTE_SIZE)
      if word then append_text(item, ", " .. (part.name or "") .. word) end
    end
  end

  local function add_attribute(tree, data)
    if data.length ~= ATTRIBUTE_SIZE then return nil end
    local attribute = get_number(data, 1, ATTRIBUTE_SIZE)

    if tree then show_attribute(tree, data, attribute) end
    return strformat("0x%08x", attribute)
  end


  local function is_number(layout)
    local format = layout.format

    return format == UNSIGNED or format == SIGNED or format == HEXADECIMAL
      or (format == FLOATING and is_described(layout))
  end

  -- The digits of a value, up to its unit, and in decimal.
  local function digits_of(value)
    local hexadecimal = match(value, "^0x(%x+)")

    if hexadecimal then return "0x" .. hexadecimal, tostring(UInt64.fromhex(hexadecimal)) end
    local digits = match(value, "^[%d.e+-]+")

    return digits, digits
  end

  -- The bits that are set and have a name.
  local function add_named_bits(item, data, at, layout, bytes)
    for number, name in string.gmatch(layout.bits, "(%d+)=([^,]+)") do
      local place = at + 1 + floor(number / 8)

      if number / 8 < layout.size and floor(byte(bytes, place) / 2 ^ (number % 8)) % 2 == 1 then
        add(item, F.value_bit, data.tvb, data.offset + at, layout.size, name, "Bit " .. number .. ": " .. name)
      end
    end
  end

  -- A value as text, and the number in this text: a filter compares what a person reads. Bits, idents and infinity
  -- have no number. An ident has its name behind it, from the tables only: what the bus says of it comes and goes.
  local function add_value_item(tree, data, at, layout, value, words, bytes)
    local item = add(tree, F.value, data.tvb, data.offset + at, layout.size, value, words)
    local ident = tree and read_ident(bytes, at + 1, layout)
    local name = ident and S.known_from_tables(ident, data.path).name

    if name then append_text(item, " (" .. name .. ")") end
    if tree and layout.bits then add_named_bits(item or tree, data, at, layout, bytes) end
    if not is_number(layout) or not is_wanted(tree, F.value_number) then return end
    local shown, digits = digits_of(value)
    local number = S.shown_number(digits)

    if number then
      set_generated(add(item or tree, F.value_number, data.tvb, data.offset + at, layout.size, number,
        "Number: " .. shown))
    end
  end

  -- All elements of a list. The position of a segment's first element in its list is unknown.
  local function show_list(tree, data, offset, layout, is_whole)
    local size, length = layout.size, data.length - offset
    local count, rest = floor(length / size), length % size
    local bytes = ordered(data, offset, size)
    local subtree = add_subtree(tree, data.tvb, data.offset + offset, length,
      strformat("%d element%s", count, plural(count)))

    for i = 0, min(count, K.SHOWN_IN_TREE) - 1 do
      local at = offset + i * size
      local value = value_text(bytes, at + 1, layout)

      add_value_item(subtree, data, at, layout, value,
        is_whole and strformat("Element %d: %s", i + 1, value) or nil, bytes)
    end
    if rest > 0 then add(subtree, F.raw, data.tvb, data.offset + data.length - rest, rest) end
  end

  -- All elements into the tree, the first few into the text.
  local function add_list(tree, data, layout, is_whole)
    local offset = add_list_header(tree, data, is_whole)
    local count, values = floor((data.length - offset) / layout.size), {}
    local bytes = ordered(data, offset, layout.size)

    if is_wanted(tree, F.value) or is_wanted(tree, F.value_number) or is_wanted(tree, F.value_bit)
      or is_wanted(tree, F.raw) then
      show_list(tree, data, offset, layout, is_whole)
    end
    for i = 1, min(count, K.SHOWN_IN_LIST) do
      values[i] = value_text(bytes, offset + (i - 1) * layout.size + 1, layout)
    end
    if count > K.SHOWN_IN_LIST then values[#values + 1] = strformat("... (%d elements)", count) end
    return count > 0 and concat(values, ", ") or "empty"
  end

  -- Operating data, minimum or maximum; the limits of a list have the length of one element.
  local function add_value_of(tree, data, element, known, is_whole)
    local layout = known and read_layout(known)

    if not layout then return nil end
    if element ~= K.ELEMENT_DATA and data.length == layout.size then layout.is_list = false end
    if layout.is_list and layout.format == TEXT then return add_text(tree, F.value, data, is_whole) end
    if layout.is_list then return add_list(tree, data, layout, is_whole) end
    if data.length ~= layout.size then return nil end
    local bytes = ordered(data, 0, layout.size)
    local text = value_text(bytes, 1, layout)

    add_value_item(tree, data, 0, layout, text, nil, bytes)
    return text
  end

  -- The number word alone does not tell the kind of a control parameter.
  local function add_ident(tree, data, asked)
    if data.length ~= 2 or not asked then return nil end
    local text = S.ident(asked.type, get_number(data, 1, 2)).text

    add(tree, F.value, data.tvb, data.offset, data.length, text)
    return text
  end

  local function attribute_misfit(data, is_whole)
    if data.length ~= ATTRIBUTE_SIZE then return is_whole and "an attribute has 4 bytes" or nil end
    local attribute = get_number(data, 1, ATTRIBUTE_SIZE)
    local is_undefined = bits(attribute, 23, 1) + bits(attribute, 31, 1) > 0

    return is_undefined and "undefined bits of the attribute" or nil
  end

  -- Why the data of an element do not fit its attribute, in words; nil: they fit.
  function S.element_misfit(data, element, known, is_whole)
    if element == K.ELEMENT_ATTRIBUTE then return attribute_misfit(data, is_whole) end
    local layout = element >= K.ELEMENT_MINIMUM and data.length > 0 and known and read_layout(known)

    if not layout then return nil end
    if not layout.is_list and data.length ~= layout.size then return "another length than its attribute says" end
    local rest = (data.length - (is_whole and list_header_size(data) or 0)) % layout.size

    if data.length ~= layout.size and rest > 0 then return "the last element is incomplete" end
    return not is_described(layout) and "no document describes a value of this format and length" or nil
  end

  -- The number in the text of such data, as displayed; nil if it has none: bits, idents, lists, infinity.
  function S.element_number(data, known, text)
    local layout = read_layout(known)

    if not layout or layout.is_list or data.length ~= layout.size or not is_number(layout) then return nil end
    local _, digits = digits_of(text)

    return digits
  end

  -- Adds the data of an element: bytes as sis.data, and their meaning as far as known. Returns a short text for the
  -- packet list ("12.5000 rpm", "\"Velocity command value\""), nil if bytes are the best. `is_whole` is false for a
  -- segment of a list; `ident` is nil if the command is unknown. `data.is_big`: in the byte order of other
  -- transports. `data.path`: the stations to the device; nil if unknown.
  function S.add_element(tree, _, data, element, ident, known, is_whole)
    if data.length == 0 then return nil end
    add(tree, F.data, data.tvb, data.offset, data.length)
    if element == K.ELEMENT_IDENT then return add_ident(tree, data, ident) end
    if element == K.ELEMENT_NAME then return add_text(tree, F.element_name, data, is_whole) end
    if element == K.ELEMENT_ATTRIBUTE then return add_attribute(tree, data) end
    if element == K.ELEMENT_UNIT then return add_text(tree, F.element_unit, data, is_whole) end
    if element >= K.ELEMENT_MINIMUM then return add_value_of(tree, data, element, known, is_whole) end
  end
end

--- sis/access: what was read and written: an access to the operating data of a parameter, told by the reaction to it.
-- Nothing is made unless somebody asks for the field.

do
  local SHOWN_BYTES, SHOWN_CHARACTERS = 16, 80

  -- Whether somebody wants the field in this tree.
  function S.is_access_wanted(tree)
    return is_wanted(tree, F.access)
  end

  -- A reaction that comes twice is counted once, one from before this file not at all.
  local function is_known(body)
    local record, asked = body.record, body.asked

    return record and not record.reaction_before and asked and asked.has_ident and asked.element == K.ELEMENT_DATA
      and not body.is_short and not body.telegram.is_before
  end

  local function bytes_text(bytes)
    if #bytes <= SHOWN_BYTES then return hex(bytes) end
    return strformat("%s... (%d bytes)", hex(sub(bytes, 1, SHOWN_BYTES)), #bytes)
  end

  local function set_value(access, bytes)
    local data = {bytes = bytes, length = #bytes, offset = 0}
    local text = S.add_element(nil, nil, data, K.ELEMENT_DATA, access.ident, access.known, true)

    access.bytes, access.is_raw = bytes, not text
    access.number = text and S.element_number(data, access.known, text)
    access.value = text and S.shortened(text, SHOWN_CHARACTERS) or bytes_text(bytes)
  end

  -- A character of UTF-8 as its code, or as both codes that JSON needs.
  local function escaped(character)
    local size = #character
    local code = size == 1 and byte(character) or byte(character) % 2 ^ (7 - size)

    for place = 2, size do
      code = code * 64 + byte(character, place) % 64
    end
    if code < 0x10000 then return strformat("\\u%04x", code) end
    return strformat("\\u%04x\\u%04x", 0xD800 + floor((code - 0x10000) / 0x400), 0xDC00 + code % 0x400)
  end

  local function quoted(text)
    return '"' .. gsub(text, '["\\%c\128-\255][\128-\191]*', escaped) .. '"'
  end

  -- A JSON object; unknown values are left out.
  local function json_text(access)
    local known = access.known
    local parts = {strformat('{"access":"%s"', access.is_write and "write" or "read")}

    local function append(name, text)
      if text then parts[#parts + 1] = strformat('"%s":', name) .. text end
    end

    append("master", access.master)
    append("station", quoted(access.station))
    append("device", access.device)
    append("parameter", quoted(access.ident.text))
    append("error", access.error and quoted(access.error))
    append("value", access.value and quoted(access.value))
    append("number", access.number)
    append("raw", access.is_raw and "true")
    append("data", access.bytes and quoted(gsub(hex(access.bytes), " ", "")))
    append("text", access.text and quoted(access.text))
    append("name", known.name and quoted(known.name))
    append("unit", known.unit and quoted(known.unit))
    append("minimum", known.minimum and quoted(known.minimum))
    append("maximum", known.maximum and quoted(known.maximum))
    return concat(parts, ",") .. "}"
  end

  function S.tell_access(access, tvb, tree)
    set_hidden(add(tree, F.access, tvb, 0, 0, json_text(access)))
  end

  local function note(body, is_write, error_text, bytes)
    local from, asked = body.record.exchange.from, body.asked
    local access = {
      is_write = is_write,
      error = error_text, -- of a refused access
      master = body.ends.listener,
      station = concat({byte(from.path, 1, -1)}, "/"),
      device = asked.device,
      ident = asked.ident,
    }
    local known = S.learned_known(body, asked.ident, asked.device) -- when the command was sent

    access.known = S.learned_complete(body, asked.ident, asked.device, known)

    if bytes and #bytes > 0 then set_value(access, bytes) end
    S.tell_access(access, body.tvb, body.tree)
  end

  -- A reaction has brought the last data of a read, which may be incomplete.
  function S.note_read(body)
    if S.is_access_wanted(body.tree) and is_known(body) then note(body, false, nil, body.data and body.data.bytes) end
  end

  local function error_text(body)
    if not body.error_text then return body.status_text end
    return strformat("0x%04x %s", body.error, body.error_text)
  end

  -- A reaction has accepted a write, or refused a read or write.
  function S.note_answer(body, is_write)
    if not S.is_access_wanted(body.tree) or not is_known(body) then return end
    if body.status ~= 0 then
      note(body, is_write, error_text(body), nil)
    elseif body.asked.is_last then
      note(body, true, nil, body.asked.written)
    end
  end
end

--- sis/times: when characters came, and how exactly that is known.
--
-- A character has the time of the read that delivered it, the latest at which it can have come; it came no earlier than
-- the record's uncertainty before that. Characters of one read follow one another by at least a character time, so the
-- i-th of k came at least (k - i) character times before the read, and if the read is longer than its uncertainty, the
-- uncertainty was too small. Neighbouring reads bound each other in the same way.

K.ANY_TIME = math.huge -- the most, where there is no bound
K.SET_BACK = -math.huge -- the least of a duration during which the clock was set back
-- Where a duration begins to count: the preference sis.tza_from.
K.FROM_UNKNOWN, K.FROM_END, K.FROM_START = 0, 1, 2

do
  local flags_of = T.flags_of

  -- The shortest time of a character, slightly short: a transmitter may be that much faster than its nominal rate.
  local function shortest_character(record)
    return floor(record.character_ns * 98 / 100)
  end

  -- The number of characters of the telegram from the read that begins with `character`.
  local function read_size(times, character)
    local record, finish, after = times.record, times.first + times.count, character + 1

    while after < finish and band(flags_of(record, after), K.SERTAP_SAME_READ) ~= 0 do
      after = after + 1
    end
    return after - character
  end

  -- A read of some of the telegram's characters: its size, and in ns from the first of them to the last, at least
  -- (others), and so long before the read the first may have come (earliest).
  local function read_at(times, character)
    local record, size = times.record, read_size(times, character)
    local uncertainty = record.uncertainty or K.ANY_TIME

    if size == 1 then return 1, 0, uncertainty end
    local others = (size - 1) * shortest_character(record)

    return size, others, max(uncertainty, others)
  end

  local function bound(times)
    local last = times.first + times.count - 1
    local _, others, earliest = read_at(times, times.first)

    times.begin_earliest = times.begin - earliest
    times.begin_latest = times.begin - others
    while last > times.first and band(flags_of(times.record, last), K.SERTAP_SAME_READ) ~= 0 do
      last = last - 1
    end
    _, others, earliest = read_at(times, last)
    times.end_earliest = times.end_ - earliest + others
  end

  -- Of the telegram being dissected: one table for all of them.
  local current = {}

  -- Without times of characters: the time of its packet.
  local function packet_times_only()
    current.record = nil
    current.begin, current.end_ = packet.time, packet.time
    current.begin_earliest, current.begin_latest, current.end_earliest = nil, nil, nil
    return current
  end

  -- The times of the telegram that `tvb` begins with, in ns; record is nil where only the time of its packet is known:
  -- {record, first, count: of the record's characters, begin, end_: as recorded, begin_earliest, begin_latest,
  -- end_earliest: nil where they are not known}. They hold until the next telegram.
  function S.times(tvb, there, length)
    local record = packet.record

    if not record then return packet_times_only() end
    local times = current
    local first, timed = there == record.declared and 0 or T.index(record, tvb), record.timed

    if length == 0 or first < 0 or first + length > timed then return packet_times_only() end
    local uncertainty, begin = record.uncertainty, packet.time
    local end_ = begin + record.duration

    if length < timed then
      begin = packet.time + T.since_first(record, first)
      end_ = packet.time + T.since_first(record, first + length - 1)
    end
    times.record = record
    times.first, times.count = first, length
    times.begin, times.end_ = begin, end_
    -- If every character came in a read of its own.
    times.begin_earliest = uncertainty and begin - uncertainty
    times.begin_latest = uncertainty and begin
    times.end_earliest = uncertainty and end_ - uncertainty
    if uncertainty and band(record.flags, K.SERTAP_SAME_READ) ~= 0 then bound(times) end
    return times
  end

  local NOT_MEASURED = K.SERTAP_INTERVAL_UNKNOWN + K.SERTAP_INTERVAL_SATURATED + K.SERTAP_ERROR_LOST
  local UNKNOWN_OR_LOST = K.SERTAP_INTERVAL_UNKNOWN + K.SERTAP_ERROR_LOST
  local UNKNOWN_OR_SATURATED = K.SERTAP_INTERVAL_UNKNOWN + K.SERTAP_INTERVAL_SATURATED

  local function is_measured_before(record, character)
    return record.flags == 0 or band(flags_of(record, character), UNKNOWN_OR_LOST) == 0
  end

  -- All reads of a telegram, by number, as read_at() describes them: first is of the record's characters, and the last
  -- had come so long before the read (latest). The same lists for all telegrams: a table for each read takes most of
  -- the time.
  local firsts, sizes, others, earliest, latest = {}, {}, {}, {}, {}

  -- Returns how many there are. No character came before the one before it: what is known of a read bounds its
  -- neighbours, forwards and backwards.
  local function find_reads(times)
    local record, character, count = times.record, times.first, 0
    local intervals, uncertainty = T.intervals(record), record.uncertainty or K.ANY_TIME
    local shortest, finish = shortest_character(record), character + times.count
    local are_alone = band(record.flags, K.SERTAP_SAME_READ) == 0

    while character < finish do
      count = count + 1
      firsts[count], sizes[count], others[count], earliest[count], latest[count] = character, 1, 0, uncertainty, 0
      if not are_alone then sizes[count], others[count], earliest[count] = read_at(times, character) end
      character = character + sizes[count]
    end
    if not record.uncertainty then return count end
    for i = 2, count do
      local since = intervals[firsts[i] + 1] + earliest[i - 1] - others[i - 1] - shortest

      if since < earliest[i] and is_measured_before(record, firsts[i]) then earliest[i] = max(since, others[i]) end
    end
    for i = count, 2, -1 do
      local before = shortest - (intervals[firsts[i] + 1] - others[i] - latest[i])

      if before > 0 and is_measured_before(record, firsts[i]) then
        latest[i - 1] = min(before, earliest[i - 1] - others[i - 1])
      end
    end
    return count
  end

  -- Between the last character of the read before and the first of a read: least and most.
  local function span_before(record, i, interval)
    if not record.uncertainty then return 0, K.ANY_TIME end
    local least = interval - earliest[i] + latest[i - 1]
    local most = interval - others[i] - latest[i] + earliest[i - 1] - others[i - 1]

    if record.flags ~= 0 then
      if not is_measured_before(record, firsts[i]) then least = 0 end
      if band(flags_of(record, firsts[i]), UNKNOWN_OR_SATURATED) ~= 0 then most = K.ANY_TIME end
    end
    return least > 0 and least or 0, most
  end

  -- Between any two characters of one read.
  local function span_inside(record, i)
    local shortest = shortest_character(record)

    return shortest, record.uncertainty and shortest + earliest[i] - latest[i] - others[i] or K.ANY_TIME
  end

  -- A start character and two equal lengths: a receiver restarts there after too long a pause, if the character
  -- follows directly (chapter 10.5).
  local function looks_like_start(times, at)
    local record = times.record
    local start, _, length, length_repeat = byte(record.bytes, record.data_offset + times.first + at,
      record.data_offset + times.first + at + 3)

    return start == K.START and at + 3 <= times.count and length == length_repeat
  end

  -- Of several, one that is exceeded decides, then one that is unresolved.
  local function worsen(verdict, next_)
    return (verdict == K.TIME_OK or next_ == K.TIME_EXCEEDED) and next_ or verdict
  end

  -- The verdict on an interval that may be beyond the limit; returns whether it is.
  local function judge_interval(longest, times, at, span, flags)
    local whole, idle = S.judge_both(span, times.record.character_ns, longest.limit)
    local verdict = S.verdict(whole, idle, longest.from)

    if verdict == K.TIME_EXCEEDED and not longest.restart_at and looks_like_start(times, at) then
      longest.restart_at = at
    end
    longest.verdict = worsen(longest.verdict, verdict)
    longest.whole, longest.idle = worsen(longest.whole, whole), worsen(longest.idle, idle)
    if verdict == K.TIME_UNRESOLVED and band(flags, UNKNOWN_OR_LOST) ~= 0 then
      longest.unknown_at = longest.unknown_at or at
    end
    return verdict == K.TIME_EXCEEDED
  end

  local function consider(longest, times, at, recorded, is_exact, least, most)
    if most <= longest.enough then return end
    local flags, was_exceeded = flags_of(times.record, times.first + at - 1), longest.verdict == K.TIME_EXCEEDED
    local is_exceeded = most > longest.limit
      and judge_interval(longest, times, at, {least = least, most = most}, flags)
    local weight = is_exceeded and least or most ~= K.ANY_TIME and most or recorded -- an upper bound, where it counts

    if band(flags, UNKNOWN_OR_LOST) ~= 0 then return end
    if not longest.interval or (is_exceeded and not was_exceeded)
      or (is_exceeded == was_exceeded and weight > longest.interval.weight) then
      longest.enough = min(weight, longest.limit)
      longest.interval = {at = at, recorded = recorded, is_exact = is_exact, weight = weight,
        span = {least = least, most = most}, is_saturated = band(flags, K.SERTAP_INTERVAL_SATURATED) ~= 0}
    end
  end

  -- The interval that is, or may be, the longest of a telegram: one that exceeds the limit (0: none) where any does.
  -- With the verdict over all of them, the first character after too long a pause where a telegram seems to begin
  -- (restart_at), and the one before which nobody knows how long it was, and it matters (unknown_at). An interval: {at:
  -- number of the character in the telegram, from 1, recorded, span, weight: the largest is the longest, is_exact: both
  -- its characters came alone, each in a read of its own, is_saturated: it was longer than recorded}; nil where there
  -- is none. An interval that can have been no longer than `enough` changes nothing.
  function S.longest(times, limit, from)
    -- Without a limit nothing exceeds it: the most that an interval can have been counts.
    local longest = {verdict = K.TIME_OK, whole = K.TIME_OK, idle = K.TIME_OK, from = from,
      limit = limit ~= 0 and limit or K.ANY_TIME, enough = K.SET_BACK}
    local record, first, intervals = times.record, times.first, T.intervals(times.record)

    for i = 1, find_reads(times) do
      local at, size = firsts[i] - first + 1, sizes[i]

      if i > 1 then
        local recorded = intervals[firsts[i] + 1]

        consider(longest, times, at, recorded, size == 1 and sizes[i - 1] == 1, span_before(record, i, recorded))
      end
      if size > 1 then consider(longest, times, at + 1, 0, false, span_inside(record, i)) end
    end
    return longest.interval and longest
  end

  -- Whether all intervals are within the limit, whatever the uncertainty: quicker than examining each of them.
  function S.are_within(times, limit)
    local record = times.record

    return record.uncertainty
      and band(record.flags, NOT_MEASURED) == 0
      and max(T.longest(record), shortest_character(record)) + record.uncertainty <= limit
  end

  -- Whether a duration up to this telegram was measured: in a read of the tap all characters have its time, and a clock
  -- that was set back measures nothing.
  function S.is_measured(elapsed, times)
    return elapsed > 0 or elapsed == 0 and not times.record
  end

  -- Of a duration. After a clock was set back it is not known.
  function S.span(least, most)
    if most < 0 then return {least = K.SET_BACK, most = K.ANY_TIME} end
    return {least = least, most = most}
  end

  -- From the end of one telegram to the beginning of another.
  function S.span_between(end_earliest, end_, after)
    return S.span(T.elapsed(end_, after.begin_earliest), T.elapsed(end_earliest, after.begin_latest))
  end

  -- exceeded, ok or unresolved (see plugin/docs/verdicts.md); the limit in ns.
  function S.judge(span, limit)
    if span.least > limit then return K.TIME_EXCEEDED end
    return span.most <= limit and K.TIME_OK or K.TIME_UNRESOLVED
  end

  -- Of a duration that ends with a character (ns; 0: unknown). No document says whether that one counts: the verdict
  -- with it, and the one without.
  function S.judge_both(span, character, limit)
    local longest = character > 0 and character or K.LONGEST_CHARACTER
    local idle = {least = max(span.least, longest) - longest, most = max(span.most - character, 0)}

    return S.judge(span, limit), S.judge(idle, limit)
  end

  -- Where nobody knows what counts, what both say.
  function S.verdict(whole, idle, from)
    if from == K.FROM_END then return idle end
    if from == K.FROM_START then return whole end
    if idle == K.TIME_EXCEEDED then return idle end
    return whole == K.TIME_OK and K.TIME_OK or K.TIME_UNRESOLVED
  end
end

--- sis/asked: a request and its answer, in all protocols but SIS: {frame: its own, request_in, answer_in, line: of a
-- tap with two directions, else 0, finish, finish_earliest, elapsed, span: of an answer, since its request}

do
  -- First pass: begins with what its packet says.
  function S.asked_new(times)
    return {frame = packet.number, line = packet.record and packet.record.line or 0, finish = times.end_,
      finish_earliest = times.end_earliest}
  end

  -- Nobody answers himself. A shared line does not show who has sent what.
  function S.may_answer(answer, request)
    return request and (answer.line == 0 or answer.line ~= request.line)
  end

  -- First pass: connects both; `times` are those of the answer.
  function S.asked_answer(answer, request, times)
    request.answer_in = request.answer_in or answer.frame
    answer.request_in = request.frame
    answer.elapsed = T.elapsed(request.finish, times.begin)
    answer.span = {least = 0, most = K.ANY_TIME}
    if request.finish_earliest and times.begin_earliest then
      answer.span = S.span_between(request.finish_earliest, request.finish, times)
    end
  end

  -- Adds what is known of it.
  function S.asked_show(asked, tree, tvb, request_in, answer_in, time)
    add_generated(tree, FX[answer_in], tvb, asked.answer_in)
    add_generated(tree, FX[request_in], tvb, asked.request_in)
    if asked.request_in then S.add_ms(tree, FX[time], tvb, asked.elapsed) end
  end
end

--- sis/bus: what the bus has told about itself, slave by slave and for all (chapter 6). A value counts as told
-- with the slave's good reaction, or at once where nobody answers; subservice 0xFF makes valid what was told.

-- Instead of a station's address: valid for all.
K.ALL_STATIONS = 255

-- Kinds of settings.
K.TRS, K.TZA, K.TMAS, K.BAUD = 1, 2, 3, 4

do
  -- Subservices (chapter 6.1).
  local TEST_BAUD, ACCEPT = 0x08, 0xFF

  local kinds = {[0x01] = K.TRS, [0x02] = K.TZA, [0x03] = K.TMAS, [0x07] = K.BAUD} -- what the others set

  -- A setting: {value: ms or Bd, set_in: the command or event, accepted_in: nil before that, order: of all settings of
  -- the bus}. Settings are keyed by kind, and never changed once made.

  -- The settings of a bus: empty at first.
  function S.told_new()
    return {
      stations = {}, -- by address, {told, valid}: settings; valid as far as they were accepted for this station
      tests = {}, -- by address: {rate: a setting, finish: ns}: a timed test of a baud rate
      known = {}, -- S.bus_settings() of each station, nil before it is made
      is_anything_told = false,
      last_order = 0,
    }
  end

  local function copy(settings)
    local made = {}

    for kind, setting in pairs(settings) do
      made[kind] = setting
    end
    return made
  end

  -- When a station is first told something, the values for all hold for it so far.
  local function find_station(told, address)
    local all = told.stations[K.ALL_STATIONS]

    if not told.stations[address] then
      told.stations[address] = {told = {}, valid = copy(all and all.valid or {})}
    end
    return told.stations[address]
  end

  local function order_of(setting)
    return setting and setting.order or 0
  end

  local function next_order(told)
    told.last_order = told.last_order + 1
    return told.last_order
  end

  -- Makes the set values for a station or for all valid, if they are newer. A new rate ends a test.
  local function accept(told, number, frame)
    local station, all = told.stations[number], told.stations[K.ALL_STATIONS]

    for kind = K.TRS, K.BAUD do
      local setting = station.told[kind]

      if order_of(all.told[kind]) > order_of(setting) then setting = all.told[kind] end
      if order_of(setting) > order_of(station.valid[kind]) then
        station.valid[kind] = {value = setting.value, set_in = setting.set_in, accepted_in = frame,
          order = setting.order}
        if kind == K.BAUD then told.tests[number] = nil end
      end
    end
  end

  -- `now`: the end of the telegram that makes this valid.
  local function learn(told, address, request, command, frame, now)
    local setting = {value = request.setting, set_in = command, order = next_order(told)}
    local station = find_station(told, address)
    local kind = kinds[request.subservice]

    told.is_anything_told = true
    told.known = {}
    if request.subservice == ACCEPT then
      find_station(told, K.ALL_STATIONS)
      for number in pairs(told.stations) do
        if address == K.ALL_STATIONS or address == number then accept(told, number, frame) end
      end
    end
    if request.subservice == TEST_BAUD then
      told.tests[address] = {rate = setting, finish = now + request.test_ms * 1000000}
    end
    if kind then station.told[kind] = setting end
  end

  -- Whether this telegram makes a setting count: the good reaction of a station of this line, or a command to all.
  -- Settings through a router are for another line.
  local function is_told(body, is_for_all)
    if body.telegram.subaddress_count > 0 then return false end
    if not body.is_reaction then return is_for_all end
    return not is_for_all and body.status == 0 and not body.record.reaction_before
  end

  -- First pass: takes a command or reaction of service 0x03. A slave reacts to 0xFF with the new values
  -- already.
  function S.bus_learn(body)
    local telegram, exchange = body.telegram, body.record.exchange
    local request = body.is_reaction and body.asked or body.request
    local kind = S.receiver_kind(telegram.receiver)
    local is_for_all = kind == K.LEVEL_BROADCAST or kind == K.GLOBAL_BROADCAST

    if not request or not is_told(body, is_for_all) then return end
    effects = effects + 1
    local told = exchange.from.stream.bus.told
    local address = is_for_all and K.ALL_STATIONS or byte(exchange.from.path)

    local further = request.list -- subservices of the same telegram
    while request do
      if request.has_setting then
        learn(told, address, request, exchange.command_in, packet.number, telegram.times.end_)
        if body.is_reaction and request.subservice == ACCEPT then
          body.record.settings = S.bus_settings(told, address, telegram.times.begin)
        end
      end
      request, further = further, further and further.next
    end
  end

  -- "TzA = 8 ms" in a text; 0: it is not there, or no time that a bus can be told.
  local function find_limit(text, name)
    local _, last = string.find(text, name, 1, true)
    local value = last and tonumber(string.match(text, "^%d+", last + 1)) or 0

    return value <= 0xFFFF and value or 0
  end

  local function learn_limit(told, kind, value)
    for _, station in pairs(told.stations) do
      local valid = station.valid[kind]

      if not valid or valid.is_by_user then
        station.valid[kind] = {value = value, set_in = told.limits_in, accepted_in = told.limits_in, is_by_user = true}
      end
    end
  end

  local limit_names = {[K.TZA] = "TzA = ", [K.TRS] = "TrS = "}

  -- First pass: takes over what the user told of this bus. It counts for stations that the bus has told nothing.
  function S.bus_learn_limits(told, limits)
    if not limits or told.limits_in == limits.told_in then return end
    told.limits_in = limits.told_in
    told.is_anything_told = true
    told.known = {}
    find_station(told, K.ALL_STATIONS)
    for kind, name in pairs(limit_names) do
      local value = find_limit(limits.text, name)

      if value ~= 0 then learn_limit(told, kind, value) end
    end
  end

  local function make_settings(told, address)
    local station = told.stations[address] or told.stations[K.ALL_STATIONS]
    local test = told.tests[address] or told.tests[K.ALL_STATIONS]
    local settings = copy(station and station.valid or {})

    if test then settings[K.BAUD] = test.rate end
    return settings
  end

  local function end_test(told, address, now)
    local test = told.tests[address]

    if test and now > test.finish then
      told.tests[address] = nil
      told.known = {}
    end
  end

  -- First pass: what is valid for a station, or for all, now (ns); nil if nothing was set.
  function S.bus_settings(told, address, now)
    if not told.is_anything_told then return nil end
    end_test(told, address, now)
    end_test(told, K.ALL_STATIONS, now)
    told.known[address] = told.known[address] or make_settings(told, address)
    return told.known[address]
  end
end

--- sis/cycle: the cycle in which a master sends its master control word to a drive, which Tmas limits (chapter
-- 10). First pass only.

do
  local MS = 1000000 -- in ns
  local DEAD_BUS_SILENCE = K.LONGEST_INTERVAL -- after a silence that a record cannot hold, the bus is dead

  -- Whether a command writes the master control word: S-0-0134 of SERCOS. The documents do not name the telegram that
  -- carries it.
  local function find_control_word(request)
    local ident = request.ident

    if ident and ident.type == 0 and ident.number == 134 and request.element == K.ELEMENT_DATA
      and S.general_service(request.service) == 0x1F then
      return request
    end
    local element = request.list

    while element do
      if find_control_word(element) then return element end
      element = element.next
    end
  end

  -- Two master control words to the same drive: the frame of the one before, and the time from beginning to
  -- beginning.
  local function make_cycle(last, times)
    local span = {least = 0, most = K.ANY_TIME}

    if times.begin_earliest and last.begin_earliest then
      span = S.span(T.elapsed(last.begin_latest, times.begin_earliest),
        T.elapsed(last.begin_earliest, times.begin_latest))
    end
    return {frame = last.frame, ns = T.elapsed(last.begin, times.begin), span = span}
  end

  -- Of a bus, made when the first master control word comes: {words: the last to each drive, heard: when the last
  -- telegram ended, dead_in: the last telegram after too long a silence}.
  function S.cycle_heard(cycles, times)
    if not cycles then return end
    if T.elapsed(cycles.heard, times.begin) > DEAD_BUS_SILENCE then cycles.dead_in = packet.number end
    cycles.heard = times.end_
  end

  -- Tmas holds while the machine moves. After what ended here, the next word begins anew (plugin/docs/verdicts.md).
  local function cycle_ended_in(record, times)
    local stream, limit = record.exchange.from.stream, record.settings and record.settings[K.TMAS]
    local ended_in = max(stream.idle_in, stream.bus.lost_in)

    if times.record then ended_in = max(ended_in, times.record.known.begun_in) end
    if limit then ended_in = max(ended_in, limit.accepted_in or 0) end
    if not limit or limit.value * MS < DEAD_BUS_SILENCE then ended_in = max(ended_in, stream.bus.cycles.dead_in) end
    return ended_in
  end

  -- Takes a command that may carry a master control word.
  function S.cycle_learn(record, times, command)
    local request = find_control_word(command)

    if not request then return end
    local stream = record.exchange.from.stream
    local cycles = stream.bus.cycles or {words = {}, dead_in = 0}
    local key = stream.number * 256 + (request.device or 0)
    local last = cycles.words[key]

    stream.bus.cycles = cycles
    if last and cycle_ended_in(record, times) <= last.frame then record.cycle = make_cycle(last, times) end
    cycles.heard = times.end_
    cycles.words[key] = {
      frame = packet.number,
      begin = times.begin,
      begin_earliest = times.begin_earliest,
      begin_latest = times.begin_latest,
    }
  end
end

--- sis/learn: the first pass: what is learned from a telegram, in the order of the capture, and written into its
-- record. First its relations and what is valid for it; then, as soon as it is decoded, what it says. Only the place of
-- a piece must be known while it is decoded (sis/sequence).

do
  local records -- by place in the packet, then by frame number

  at_init(function() records = {} end)

  -- The limits valid for a telegram. The slave of a swapped reaction is in its command.
  local function learn_settings(record, bus, telegram)
    if packet.record then S.bus_learn_limits(bus.told, packet.record.known.limits) end
    if not telegram.is_before then S.cycle_heard(bus.cycles, telegram.times) end
    if not bus.told.is_anything_told then return end
    local address = record.exchange and byte(record.exchange.from.path) or telegram.receiver

    if not telegram.is_good or not S.is_answered(address) then address = K.ALL_STATIONS end
    record.settings = S.bus_settings(bus.told, address, telegram.times.begin)
  end

  -- The record of the next telegram of its packet: in the first pass made from what is known so far, later as it was
  -- made then. Never nil.
  function S.learn_telegram(pinfo, telegram)
    local number, place = packet.number, packet.count + 1 -- several telegrams may be in one packet
    local kind = telegram.service + (telegram.is_reaction and 0x100 or 0)

    packet.count = place
    records[place] = records[place] or {}
    local record = records[place][number]

    if record and record.kind == kind then return record end
    -- A telegram that the first pass did not see: TCP reassembled its segments differently.
    if record or packet.visited then return {kind = kind} end
    record = { -- with only the fields that most of them need
      kind = kind, -- identifies the telegram in later passes
      exchange = nil, -- of a damaged telegram, and of a reaction without a command
      reaction_time = nil,
      settings = nil,
    }
    records[place][number] = record
    local bus = S.exchange_bus(pinfo)

    S.exchange_learn(record, bus, number, telegram)
    learn_settings(record, bus, telegram)
    return record
  end

  -- First pass: takes what a telegram, or an element of a list, has taught; its body is decoded.
  function S.learn_body(body)
    if packet.visited then return end
    if body.learn then body.learn(body) end
    S.sequence_learn(body)
  end

  -- A request again, because there was no good reaction to the one before: it is the same step of a transfer, and
  -- writes the same.
  local function take_over(exchange, request, same, before)
    local place = request.place or 0
    local step = S.step(same, place)

    if exchange.repeat_of or step.is_to_be_repeated then
      if step.transfer and not S.step(exchange, place).transfer then
        S.make_step(exchange, place).transfer = step.transfer
      end
      request.written = request.written or before.written
    end
    if request.list and before.list then take_over(exchange, request.list, same, before.list) end
    if request.next and before.next then take_over(exchange, request.next, same, before.next) end
  end

  -- First pass: keeps what a command asks for; it may be the result of an earlier one with the same bytes.
  function S.learn_request(record, telegram, request)
    local exchange = record.exchange
    local same = exchange.from.same

    if exchange.request then return end
    exchange.request = request
    if same and same.request and (exchange.repeat_of or exchange.is_step_again) then
      take_over(exchange, request, same, same.request)
    end
    if not telegram.is_before then S.cycle_learn(record, telegram.times, request) end
  end
end

--- sis/timing: verdicts on the timing of telegrams: TzA, TrS, TwM and Tmas (chapter 10), and how busy the bus
-- is. A limit comes from a preference, else from what the bus has told, else from what the user told when capturing,
-- else there is none, and no verdict; nor is there one where only packets have times.

do
  local MS = 1000000 -- in ns
  local OPERATOR_TERMINAL_SILENCE = 200 * MS -- after it an operator terminal considers its link lost (chapter 10.1)

  -- 0: use what the bus has set.
  -- The three limits, and their display.
  local tza = {name = "TzA", limit = F.tza_limit, set_in = F.tza_set_in, verdict = F.tza_verdict,
    exceeded = E.tza_exceeded, unresolved = E.tza_unresolved}
  local trs = {name = "TrS", limit = F.trs_limit, set_in = F.trs_set_in, verdict = F.trs_verdict,
    exceeded = E.trs_exceeded, unresolved = E.trs_unresolved}
  local tmas = {name = "Tmas", limit = F.tmas_limit, set_in = F.tmas_set_in, verdict = F.tmas_verdict,
    exceeded = E.tmas_exceeded, unresolved = E.tmas_unresolved}

  -- More digits if three would look like a whole number of ms, as limits are.
  local function ms_text(ns)
    local is_close = fmod(ns, MS) ~= 0 and fmod(ns + 500, MS) < 1000

    return is_close and T.decimal_text(ns, 1, 6) .. " ms" or T.ms_text(ns)
  end

  local function span_text(span)
    if span.least == K.SET_BACK then return "the clock was set back" end
    if span.most == K.ANY_TIME then
      return span.least > 0 and "at least " .. ms_text(span.least) or "not known"
    end
    return strformat("between %s and %s", ms_text(max(span.least, 0)), ms_text(span.most))
  end

  -- A telegram whose timing is examined (t): {telegram, record, body, tree, root: of `tree`; in ns silence (nil:
  -- unknown), busy and span: of the line (nil: unknown), tza and trs: limits (0: unknown, so there is no verdict),
  -- longest (nil: unknown, or not needed), wait: TwM (negative: none)}.

  local function add_time(t, which, ns, ...)
    return S.add_time(t.tree, which, t.body.tvb, ns, ...)
  end

  local function add_uint(t, which, value, text)
    local item = add_generated(t.tree, which, t.body.tvb, value)

    if text then append_text(item, text) end
    return item
  end

  local function setting(t, kind)
    return t.record.settings and t.record.settings[kind]
  end

  -- In ns; 0: there is none.
  local function limit_of(t, kind, preference_ms)
    local told = setting(t, kind)

    if preference_ms ~= 0 then return preference_ms * MS end
    return told and told.value * MS or 0
  end

  -- Limit and verdict. The words for an expert item are the same in each packet: Wireshark groups by them. The numbers
  -- follow the verdict.
  local function show_verdict(t, judgement, told, limit, verdict, words, numbers)
    add_time(t, judgement.limit, limit, "%d ms%s", limit / MS, told and told.is_by_user and ", told by the user" or "")
    if told then add_uint(t, judgement.set_in, told.set_in) end
    local item = add_uint(t, judgement.verdict, verdict)

    if verdict == K.TIME_OK then return end
    local is_exceeded = verdict == K.TIME_EXCEEDED

    if numbers then append_text(item, ", " .. numbers) end
    add_expert(item or t.root, is_exceeded and judgement.exceeded or judgement.unresolved,
      strformat("%s %s%s", judgement.name, is_exceeded and "exceeded" or "perhaps exceeded", words))
    if is_exceeded then
      t.body.marks = t.body.marks .. strformat("  [%s exceeded]", judgement.name)
    end
  end

  local header = {"Start", "Checksum", "Data length", "Data length repetition", "Telegram control", "Service",
    "Sender address", "Receiver address"}

  -- The field of the n-th character of a telegram, from 1.
  local function position_text(t, n)
    local telegram = t.telegram
    local subaddress = n - K.STATIC_LENGTH

    if header[n] then return header[n] end
    if subaddress <= telegram.subaddress_count then return strformat("Subaddress %d", subaddress) end
    if n <= telegram.body_offset then return "Telegram number" end
    return strformat("Useful data, byte %d", n - telegram.body_offset)
  end

  -- Why a verdict is unresolved apart from the longest interval, or what a receiver does after so long a pause
  -- (chapter 10.5); and the character that decides it.
  local function verdict_words(longest)
    if longest.verdict ~= K.TIME_EXCEEDED then
      if longest.unknown_at then return ": an interval is not known" end
      return P.tza_from == K.FROM_UNKNOWN and longest.whole ~= longest.idle
        and ": depends on where TzA begins to count" or ""
    end
    return longest.restart_at and ": a receiver begins anew at a character that looks like the start of a telegram"
      or ": a receiver goes on"
  end

  local function verdict_numbers(longest)
    local is_exceeded = longest.verdict == K.TIME_EXCEEDED
    local at = is_exceeded and longest.restart_at or not is_exceeded and longest.unknown_at

    return at and strformat("%s character %d", is_exceeded and "begins anew at" or "not known before", at)
  end

  -- "12.000 ms (idle 10.854 ms": the part without the character itself.
  local function idle_text(t, ns)
    local character = t.telegram.times.record.character_ns

    if character == 0 then return ms_text(ns) .. " (idle time not known" end
    return strformat("%s (idle %s", ms_text(ns), ms_text(max(ns - character, 0)))
  end

  local function interval_text(t, interval)
    local uncertainty = t.telegram.times.record.uncertainty

    if interval.is_saturated then return "more than " .. ms_text(interval.recorded) end
    if not interval.is_exact then return span_text(interval.span) end
    if not uncertainty then return idle_text(t, interval.recorded) .. ", uncertainty unknown)" end
    return strformat("%s, uncertain by %s)", idle_text(t, interval.recorded), ms_text(uncertainty))
  end

  -- The longest interval, its place, and the verdict on TzA.
  local function show_tza(t)
    local longest = t.longest
    local interval = longest.interval
    local most = (interval.is_exact or interval.is_saturated) and interval.recorded or interval.span.most

    if most ~= K.ANY_TIME then
      add_time(t, F.tza_interval_max, most, interval_text, t, interval)
      S.add_column_ms(t.tree, F.tza_interval_max_ms, t.body.tvb, most)
    end
    add_uint(t, F.tza_position, interval.at, are_texts_read and " (" .. position_text(t, interval.at) .. ")")
    if t.tza ~= 0 then
      show_verdict(t, tza, P.tza_ms == 0 and setting(t, K.TZA), t.tza, longest.verdict, verdict_words(longest),
        verdict_numbers(longest))
    end
  end

  -- Its verdict on TrS; its span, if known; whether the verdict depends on what counts.
  function S.judge_trs(exchange, times, limit)
    local span = times.begin_earliest and exchange.command_end_earliest
      and S.span_between(exchange.command_end_earliest, exchange.command_end, times)
    local whole, idle = S.judge_both(span or {least = 0, most = K.ANY_TIME}, times.record.character_ns, limit)

    return S.verdict(whole, idle, K.FROM_UNKNOWN), span, whole ~= idle
  end

  -- The reaction time of a slave on this line; behind a router it includes times of other lines.
  local function show_trs(t)
    local exchange, times = t.record.exchange, t.telegram.times
    local verdict, span, is_ambiguous = S.judge_trs(exchange, times, t.trs)
    local words = ": how exact the times are is not known"

    if span then
      words = verdict == K.TIME_UNRESOLVED and is_ambiguous and ": depends on whether the first character counts" or ""
    end
    if t.tree or verdict ~= K.TIME_OK then
      show_verdict(t, trs, P.trs_ms == 0 and setting(t, K.TRS), t.trs, verdict, words,
        verdict ~= K.TIME_OK and span and span_text(span))
    end
  end

  -- The master's wait before a repetition, or after a broadcast. TwM is never sent, but a slave may take TrS to
  -- answer.
  local function show_twm(t)
    local wait, slave = t.wait, limit_of(t, K.TRS, P.trs_ms)
    local item = add_time(t, F.twm_wait, wait, ms_text, wait)

    if t.record.exchange.repeat_of and slave > 0 and wait < slave then
      append_text(item, strformat(", while the slave may take %d ms (TrS)", slave / MS))
      add_expert(item or t.root, E.twm_early)
    end
  end

  local function show_tmas(t)
    local cycle, longest = t.record.cycle, t.telegram.times.record and limit_of(t, K.TMAS, 0) or 0
    local is_measured = S.is_measured(cycle.ns, t.telegram.times)

    if is_measured then add_time(t, F.tmas_cycle, cycle.ns, ms_text, cycle.ns) end
    add_uint(t, F.tmas_before_in, cycle.frame)
    if longest > 0 then
      show_verdict(t, tmas, setting(t, K.TMAS), longest, S.judge(cycle.span, longest), ": a slave stops a movement",
        not is_measured and span_text(cycle.span) or nil)
    end
  end

  local function show_baud(t, rate)
    local tap = t.telegram.times.record
    local item = add_uint(t, F.bus_baud, rate.value, rate.accepted_in and "" or " (timed test)")

    add_uint(t, F.bus_baud_set_in, rate.set_in)
    if tap and tap.baud ~= 0 and tap.baud ~= rate.value then
      add_expert(item or t.root, E.bus_baud_differs,
        strformat("The bus was told %d Bd, the tap listens at %d Bd", rate.value, tap.baud))
    end
  end

  local function load_text(load)
    return T.decimal_text(load * 10, 1, 1) .. " %"
  end

  local function show_bus(t)
    local rate = setting(t, K.BAUD)

    if rate then show_baud(t, rate) end
    if t.busy and t.tree then
      local load = T.percent(t.busy, t.span)

      set_generated(add_value(t.tree, F.bus_load, t.body.tvb, 0, 0, load, load_text, load))
    end
  end

  local function silence_text(t, silence)
    return t.is_longer and "more than " .. ms_text(silence) or idle_text(t, silence) .. ")"
  end

  local function show_silence(t)
    local silence = t.silence
    S.add_column_ms(t.tree, F.silence_before_ms, t.body.tvb, silence)
    local item = add_time(t, F.silence_before, silence, silence_text, t, silence)

    if silence > OPERATOR_TERMINAL_SILENCE then
      append_text(item, ", more than the 200 ms after which an operator terminal gives up")
    end
  end

  local SILENCE_UNKNOWN = K.SERTAP_INTERVAL_UNKNOWN + K.SERTAP_ERROR_LOST + K.SERTAP_SAME_READ

  -- Before the telegram's first character, since the one before it on the line, and whether it was longer; nil if
  -- unknown.
  local function silence_before(times)
    local record, first = times.record, times.first
    local flags = record and T.flags_of(record, first)

    if not record or band(flags, SILENCE_UNKNOWN) ~= 0 then return nil end
    if first == 0 then return T.silence(record) end
    return T.interval_of(record, first), band(flags, K.SERTAP_INTERVAL_SATURATED) ~= 0
  end

  -- Examining every interval takes time: only if it is displayed, or may exceed a limit.
  local function is_longest_wanted(t)
    local tree, times = t.body.tree, t.telegram.times

    if not times.record then return false end
    if S.is_counting then return true end
    if t.tza > 0 then return tree or not S.are_within(times, t.tza) end
    return is_wanted(tree, F.tza_interval_max) or is_wanted(tree, F.tza_interval_max_ms)
      or is_wanted(tree, F.tza_position)
  end

  local function find_timing(t)
    local telegram, record = t.telegram, t.record
    local exchange = record.exchange
    local is_answer = telegram.is_good and telegram.is_reaction and record.reaction_time

    t.silence, t.is_longer = silence_before(telegram.times)
    t.tza = limit_of(t, K.TZA, P.tza_ms)
    if is_longest_wanted(t) then t.longest = S.longest(telegram.times, t.tza, P.tza_from) end
    t.trs = is_answer and telegram.subaddress_count == 0 and telegram.times.record
      and limit_of(t, K.TRS, P.trs_ms) or 0
    t.wait = exchange and not telegram.is_reaction and exchange.wait or -1
    if telegram.times.record and not unwanted[F.bus_load] then t.busy, t.span = T.load() end
  end

  local function show(t)
    local body = t.body

    t.tree = set_generated(add_subtree(body.tree, body.tvb, 0, 0, "Timing"))
    t.root = t.tree or body.root
    if t.silence then show_silence(t) end
    if t.longest then show_tza(t) end
    if t.trs > 0 then show_trs(t) end
    if t.wait >= 0 then show_twm(t) end
    if t.record.cycle then show_tmas(t) end
    show_bus(t)
  end

  -- Adds the timing of a telegram to its tree, and notes. `body` is decoded already.
  function S.timing_dissect(telegram, record, body)
    local is_asked = body.tree or record.settings or P.tza_ms ~= 0 or P.trs_ms ~= 0 or S.is_counting

    if not is_asked then return end -- nothing to display
    local t = {telegram = telegram, record = record, body = body}

    find_timing(t)
    body.timing = t
    local has_more = t.trs > 0 or t.wait >= 0 or record.cycle or setting(t, K.BAUD)
    local is_known = has_more or t.silence or t.longest or t.busy

    -- After a verdict there may be an expert item, which counts even without a tree.
    if is_known and (body.tree or has_more or t.tza > 0) then show(t) end
  end
end

--- windows/telegrams, windows/response-times: the figures of the plugin's `-z sis,tree` and `sis,srt`. They are
-- printed where the preference sis.statistics names them: tshark -q -o sis.statistics:tree,srt. In Wireshark they are
-- windows of the menu Statistics.

do
  local MS = 1000000 -- in ns
  local CYCLE, SILENCE = 100 * MS, 200 * MS -- of an operator terminal (chapter 10.1)
  local LINE_ERRORS = K.SERTAP_ERROR_CHARACTER + K.SERTAP_ERROR_BREAK + K.SERTAP_ERROR_LOST + K.SERTAP_ERROR_UNLOCATED

  sis.prefs.statistics = Pref.string("Statistics that tshark prints", "",
    "tree or srt, or both with a comma between them: tshark -q -o sis.statistics:tree,srt")
  P.statistics = ""

  -- The packet being dissected, until it is counted: {number, telegrams}. A telegram: {is_good, is_reaction, service,
  -- talker, status_text, errors, times: {record, first, count, end_}, timing, exchange, reaction_time}.
  local noted = {}

  -- While counting.
  function S.note_telegram(body, record)
    local telegram, times, errors = body.telegram, body.telegram.times, body.errors or {}

    if body.error_text then errors[#errors + 1] = strformat("0x%04x %s", body.error, body.error_text) end
    if noted.number ~= packet.number then noted = {number = packet.number, telegrams = {}} end
    table.insert(noted.telegrams, {
      is_good = telegram.is_good,
      is_reaction = telegram.is_reaction,
      service = telegram.service,
      talker = body.ends.talker,
      status_text = body.status_text,
      errors = errors,
      times = {record = times.record, first = times.first, count = times.count, begin = times.begin, end_ = times.end_,
        begin_earliest = times.begin_earliest, begin_latest = times.begin_latest},
      timing = body.timing,
      exchange = record.exchange,
      reaction_time = telegram.is_good and telegram.is_reaction and record.reaction_time
        and S.is_measured(record.reaction_time, times) and record.reaction_time or nil,
    })
  end

  -- Each kind of statistics: {title, new: makes the sums, count(sum, telegram), text(sum)}.
  local kinds = {}

  -- Counts below counts: {count, name, below: by name}.
  local function count(node, name, by)
    node.below[name] = node.below[name] or {name = name, count = 0, below = {}}
    node.below[name].count = node.below[name].count + by
    return node.below[name]
  end

  local function tick(node, name) return count(node, name, 1) end

  local function tree_lines(node, indent, lines)
    local below = {}

    for _, each in pairs(node.below) do
      below[#below + 1] = each
    end
    table.sort(below, function(a, b) return a.count > b.count or (a.count == b.count and a.name < b.name) end)
    for _, each in ipairs(below) do
      lines[#lines + 1] = strformat("%-70s  %8d", rep(" ", indent) .. each.name, each.count)
      tree_lines(each, indent + 1, lines)
    end
    return lines
  end

  local function count_line_errors(station, times)
    if not times.record or band(times.record.flags, LINE_ERRORS) == 0 then return end
    for at = times.first, times.first + times.count - 1 do
      if band(T.flags_of(times.record, at), LINE_ERRORS) ~= 0 then tick(station, "Characters with line errors") end
    end
  end

  local function station_of(all, number, telegrams)
    return count(count(all, "By station", telegrams), strformat("Station %d", number), telegrams)
  end

  -- What a station said, and which limits it did not keep.
  local function count_talker(all, telegram)
    local station, timing, times = station_of(all, telegram.talker, 1), telegram.timing, telegram.times
    local exchange, interval = telegram.exchange, timing.longest and timing.longest.interval
    local tza = timing.tza > 0 and timing.longest and timing.longest.verdict

    if tza == K.TIME_EXCEEDED then tick(station, "TzA exceeded") end
    if tza == K.TIME_UNRESOLVED then tick(station, "TzA unresolved") end
    if timing.trs > 0 and S.judge_trs(exchange, times, timing.trs) == K.TIME_EXCEEDED then
      tick(station, "TrS exceeded")
    end
    if telegram.reaction_time and T.elapsed(exchange.command_begin, times.end_) > CYCLE then
      tick(station, "Cycles above 100 ms")
    end
    if timing.silence and timing.silence > SILENCE then tick(station, "Silences above 200 ms") end
    count_line_errors(station, times)
    if interval and interval.is_exact then tick(station, "Longest interval (us)") end
  end

  -- The station that the master had to ask again, or in vain.
  local function count_asked(all, exchange)
    if exchange.repeat_of then tick(station_of(all, byte(exchange.from.path), 0), "Repeats") end
    if exchange.gave_up then tick(station_of(all, exchange.gave_up_station, 0), "Unanswered") end
  end

  kinds.tree = {
    title = "SIS telegrams",
    new = function() return {below = {}} end,
    count = function(root, telegram)
      local all = tick(root, "Telegrams")

      if not telegram.is_good then
        tick(all, "Damaged")
        return
      end
      tick(tick(tick(all, "By service"), S.service_name(telegram.service)),
        telegram.is_reaction and "Reaction" or "Command")
      count_talker(all, telegram)
      if telegram.exchange and not telegram.is_reaction then count_asked(all, telegram.exchange) end
      if telegram.status_text then tick(tick(all, "Reactions by status"), telegram.status_text) end
      for _, text in ipairs(telegram.errors) do
        tick(tick(all, "Errors"), text)
      end
    end,
    text = function(root) return concat(tree_lines(root, 0, {}), "\n") end,
  }

  local function seconds_text(ns)
    return T.decimal_text(floor(ns / 1000 + 0.5), 1, 6)
  end

  kinds.srt = {
    title = "SIS reaction times by service",
    new = function() return {} end,
    count = function(services, telegram)
      local taken = telegram.reaction_time

      if not taken then return end
      local row = services[telegram.service] or {calls = 0, least = taken, most = taken, sum = 0}

      services[telegram.service] = row
      row.calls, row.sum = row.calls + 1, row.sum + taken
      row.least, row.most = min(row.least, taken), max(row.most, taken)
    end,
    text = function(services)
      local lines = {strformat("%5s  %-50s %8s %10s %10s %10s", "Index", "Service", "Calls", "Min SRT", "Max SRT",
        "Avg SRT")}

      for service = 0, 255 do
        local row = services[service]

        if row then
          lines[#lines + 1] = strformat("%5d  %-50s %8d %10s %10s %10s", service, S.service_name(service), row.calls,
            seconds_text(row.least), seconds_text(row.most), seconds_text(row.sum / row.calls))
        end
      end
      return concat(lines, "\n")
    end,
  }

  -- A tap of Wireshark that counts one kind; `show` gets the text whenever Wireshark draws.
  local function start(kind, show)
    local tap = Listener.new("frame")
    local sum = kind.new()

    function tap.packet(pinfo)
      if noted.number ~= pinfo.number then return end
      for _, telegram in ipairs(noted.telegrams) do
        kind.count(sum, telegram)
      end
    end

    function tap.draw() show(kind.text(sum)) end

    function tap.reset() sum = kind.new() end
    return tap
  end

  local ORDER = {"tree", "srt"}
  local is_printing = false

  local function print_what_is_asked_for()
    if is_printing or not P.statistics or P.statistics == "" then return end
    is_printing = true
    S.is_counting = true
    for name in string.gmatch(P.statistics, "[^,%s]+") do
      local kind = kinds[gsub(name, "^sis,", "")]

      if kind then
        start(kind, function(text) print(strformat("\n%s:\n%s", kind.title, text)) end)
      else
        print("sis.statistics: '" .. name .. "' is none of " .. concat(ORDER, ", "))
      end
    end
  end

  at_init(print_what_is_asked_for)

  local function open_window(kind)
    return function()
      local window = TextWindow.new(kind.title)
      local tap

      S.is_counting = true
      tap = start(kind, function(text) window:set(text) end)
      window:set_atclose(function() tap:remove() end)
      retap_packets()
    end
  end

  if gui_enabled() then
    for _, name in ipairs(ORDER) do
      register_menu((gsub(kinds[name].title, " ", "/", 1)), open_window(kinds[name]), MENU_STAT_UNSORTED) -- below SIS
    end
  end
end

--- rk512/head: the Indramat head of 6 bytes: info access, axis, parameter. ARCNET 7F has it with the low byte first
-- (chapter 7), 3964R with the high byte first (chapter 8).

do
  local INFO_WRITE, INFO_OPEN = K.SYNAX_INFO_WRITE, K.SYNAX_INFO_OPEN
  local SHOWN_BYTES = 8 -- in the packet list
  local FIRST_BY_LIST, LAST_BY_LIST = 101, 108
  local CONFIGURATION = 58 -- C-0-0058 configures data block 101 (pages 7-16 and 8-11)

  K.HEAD_SIZE = 6
  -- Data blocks that have a meaning of their own: 98 to 116; nil: none.
  function S.block_text(number)
    return (range_text(number, N.synax_blocks))
  end

  -- Adds the number of a data block, with its meaning.
  function S.add_block(tree, which, tvb, offset)
    local number = tvb(offset, 1):uint()
    local text, item = S.block_text(number), add(tree, which, tvb, offset, 1)

    if text then append_text(item, " (" .. text .. ")") end
    if number >= FIRST_BY_LIST and number <= LAST_BY_LIST then
      append_text(item, strformat(", by C-0-%04d", number - FIRST_BY_LIST + CONFIGURATION))
    end
    return item
  end

  -- Adds the words of data block 99 or 100, from `offset` up to `stop`. Of other blocks nothing is known.
  function S.add_block_words(tree, root, which, tvb, offset, stop, block, is_big)
    if block ~= K.SYNAX_BLOCK_IO and block ~= K.SYNAX_BLOCK_MODE then return end
    for at = offset, stop - 2, 2 do
      (is_big and add or add_le)(tree, which, tvb, at, 2)
    end
    if block == K.SYNAX_BLOCK_MODE then
      add_expert(tree or root, EX.synax_note, "No document says which value is which mode")
    end
  end

  -- Whether the head names a parameter: undocumented bits of the info access choose other services.
  function S.is_parameter(info)
    return band(info, INFO_OPEN) == 0
  end

  -- Adds the info access; notes undocumented bits, except those in `known`. Elements and other services (pages 8-18 to
  -- 8-23) use such bits.
  function S.add_info(tree, root, tvb, offset, is_big, known)
    local info = is_big and tvb(offset, 2):uint() or tvb(offset, 2):le_uint()
    local open = band(info, INFO_OPEN - known)
    local add_bits = is_big and add or add_le
    local item = add_bits(tree, FX.synax_info, tvb, offset, 2)

    for _, bit_field in ipairs({FX.synax_info_open, FX.synax_info_last, FX.synax_info_write}) do
      add_bits(item, bit_field, tvb, offset, 2)
    end
    append_text(item, strformat(" (%s, %s)", band(info, INFO_WRITE) ~= 0 and "write" or "read",
      band(info, K.SYNAX_INFO_LAST) ~= 0 and "last transmission" or "more follows"))
    if open ~= 0 then
      add_expert(item or root, EX.synax_note, "Bits 2 to 15 of the info access are not defined. "
        .. "They may choose an element, the mode, inputs and outputs, or axes")
    end
  end

  -- The head of a command, for an answer that does not repeat it.
  function S.head_of(info, axis, ident)
    return {
      info = info,
      is_parameter = S.is_parameter(info), -- else only the info access is known
      is_last = band(info, K.SYNAX_INFO_LAST) ~= 0,
      axis = axis,
      ident = ident,
      known = S.known_from_tables(ident),
    }
  end

  -- "S-0-0237 (name), axis 2".
  local function parameter_text(head)
    local name = head.known.name

    if not head.is_parameter then return strformat("Info access 0x%04x", head.info) end

    return strformat("%s%s, axis %d", head.ident.text, name and " (" .. name .. ")" or "", head.axis)
  end

  -- Adds sis.parameter if a command named it. Returns words for the packet list.
  function S.recall_head(tree, tvb, head)
    if tree and head.is_parameter then
      S.add_ident(tree, tvb, {offset = 0, length = 0}, head.ident, head.known)
    end
    return parameter_text(head)
  end

  -- Adds the complete head of 6 bytes at `offset`. Returns the head and words for the packet list: "Read S-0-0237,
  -- axis 2".
  function S.add_head(tree, root, tvb, offset, is_big)
    local bytes = tvb(offset, K.HEAD_SIZE):bytes():raw()
    local info_low, info_high = byte(bytes, is_big and 2 or 1), byte(bytes, is_big and 1 or 2)
    local low, high = byte(bytes, is_big and 6 or 5), byte(bytes, is_big and 5 or 6)
    local info, axis, kind = info_low + info_high * 0x100, byte(bytes, 3, 4)
    local head = S.head_of(info, axis, S.ident(kind, low + high * 0x100))

    S.add_info(tree, root, tvb, offset, is_big, 0)
    if not head.is_parameter then
      add(tree, F.raw, tvb, offset + 2, K.HEAD_SIZE - 2)
      return head, parameter_text(head)
    end
    add(tree, FX.synax_axis, tvb, offset + 2, 1)
    if tree then
      S.add_ident(tree, tvb, {offset = offset + 3, length = 3, type_at = offset + 3, number_at = offset + 4,
        is_big = is_big}, head.ident, head.known)
    end
    return head, (band(info, INFO_WRITE) ~= 0 and "Write " or "Read ") .. parameter_text(head)
  end

  -- Adds the data of that parameter, from `offset` to the end of `tvb`. Returns words for the packet list.
  function S.add_head_data(tree, root, tvb, offset, is_big, head)
    local length = tvb:len() - offset
    local data = {tvb = tvb, offset = offset, length = length, is_big = is_big,
      bytes = length > 0 and tvb(offset, length):bytes():raw() or ""}
    local text, misfit

    if head.is_parameter then
      text = S.add_element(tree, nil, data, K.ELEMENT_DATA, head.ident, head.known, true)
      misfit = S.element_misfit(data, K.ELEMENT_DATA, head.known, true)
    elseif length > 0 then
      add(tree, F.raw, tvb, offset, length)
    end
    if misfit then add_expert(tree or root, EX.synax_note, misfit) end
    if text then return " = " .. text end
    if length == 0 then return "" end
    return strformat(", %d byte%s", length, plural(length)) .. (length <= SHOWN_BYTES and ": " .. hex(data.bytes) or "")
  end
end

--- rk512/rk512i: RK512 with the Indramat extension (chapter 8): a command of 10 bytes or a follow-up of 4, with data;
-- a reaction of 4 bytes, with data after FETCH. All of it has the high byte first. What does not fit into 128 bytes
-- comes in follow-ups, and what does not fit into a data block in several: DB nn first, DB 1 last (page 8-27).

do
  local COMMAND_SIZE, FOLLOW_UP_SIZE, FOLLOW_UP = 10, 4, 0xFF
  local SEND, FETCH, DATA_BLOCK = K.RK512_SEND, K.RK512_FETCH, 0x44
  -- A long list comes in DB nn to DB 1 (page 8-27). Everything else with the Indramat head is in DB 0.
  local LAST_OF_A_CHAIN, LONGEST_CHAIN = 1, 5
  local IN_WORDS = {[0x44] = true, [0x58] = true, [0x54] = true, [0x5A] = true} -- D, X, T, Z; all others in bytes

  -- A job is what a command asks for, with its follow-ups and further blocks: {command, kind, block, left: bytes of
  -- this block that are still to come, is_open: more blocks follow, info, axis, ident: of the Indramat head, nil
  -- without, pieces: {frame, bytes}, whole_in, bytes}. A telegram keeps what was asked and answered, and {job,
  -- is_piece: of several, is_first, is_last, is_repeat, command, faults: names of those below}.
  local buses, telegrams

  -- What chapter 8 does not allow; shown as notes.
  local faults = {
    {"from_both", EX.synax_note, "Both partners send commands, but a PPC only reacts (page 8-3)"},
    {"unanswered_before", EX.synax_unanswered_before, "The command before this one got no reaction"},
    {"too_many_data", EX.synax_unexpected, "More data than the command says"},
    {"too_few_data", EX.synax_short, "Fewer data than the command asks for"},
    {"too_long_for_last", EX.synax_note, "With more than 1024 bytes, bit 1 of the info access is 0 (page 8-18)"},
  }

  at_init(function() buses, telegrams = {}, {} end)

  local function bus_of()
    local key = T.bus_key()

    buses[key] = buses[key] or {}
    return buses[key]
  end

  local function word_at(bytes, at)
    return byte(bytes, at + 1) * 0x100 + byte(bytes, at + 2)
  end

  -- The only ones that SYNAX has (page 8-24).
  local function is_data_block(command, kind)
    return (command == SEND or command == FETCH) and kind == DATA_BLOCK
  end

  local function read_head(job, d)
    if not is_data_block(job.command, job.kind) or job.block > LONGEST_CHAIN
      or #d.bytes < COMMAND_SIZE + K.HEAD_SIZE then
      return
    end
    local axis, kind_of_ident = byte(d.bytes, COMMAND_SIZE + 3, COMMAND_SIZE + 4)

    job.info, job.axis = word_at(d.bytes, COMMAND_SIZE), axis
    job.ident = S.ident(kind_of_ident, word_at(d.bytes, COMMAND_SIZE + 4))
  end

  -- The first telegram of a block: a new job, or the next block of the present one.
  local function begin_block(bus, d, telegram)
    local before, command, kind, block = bus.job, byte(d.bytes, 3, 5)
    local goes_on = before and before.is_open and before.left == 0 and before.command == command
      and block + 1 == before.block
    local job = goes_on and before or {pieces = {}}

    bus.job = job
    job.command, job.kind, job.block = command, kind, block
    job.left = word_at(d.bytes, 6) * (IN_WORDS[kind] and 2 or 1)
    job.is_open = command == SEND and kind == DATA_BLOCK and block > LAST_OF_A_CHAIN and block <= LONGEST_CHAIN
    telegram.is_first = not goes_on
    telegram.is_piece = goes_on or job.is_open
    if goes_on then return end
    read_head(job, d)
    telegram.faults.too_long_for_last = job.ident and command == SEND and band(job.info, K.SYNAX_INFO_LAST) ~= 0
      and (job.is_open or job.left > K.RK512_MOST_AT_ONCE)
  end

  -- Bytes of a block, in a SEND command or in the reaction to a FETCH.
  local function take_bytes(job, telegram, bytes)
    telegram.faults.too_many_data = #bytes > job.left
    job.left = max(job.left - #bytes, 0)
    telegram.is_last = job.left == 0 and not job.is_open
    telegram.is_piece = telegram.is_piece or job.left > 0 or not telegram.is_first
    if not telegram.is_piece then return end
    S.add_piece(job, bytes, telegram.is_last)
  end

  local function note_command(bus, d, telegram)
    telegram.faults.unanswered_before = bus.request ~= nil
    bus.request = nil
    bus.master = bus.master or telegram.line ~= 0 and telegram.line or nil
    telegram.faults.from_both = telegram.line ~= 0 and telegram.line ~= bus.master
    if not d.is_follow_up then
      begin_block(bus, d, telegram)
    elseif not bus.job or bus.job.left == 0 or bus.job.command ~= byte(d.bytes, 3) then
      return -- nobody knows of what
    end
    local job = bus.job

    telegram.job, telegram.command = job, job.command
    if job.command ~= FETCH then take_bytes(job, telegram, sub(d.bytes, d.data_at + 1)) end
    bus.request = telegram
  end

  local function note_reaction(bus, d, telegram)
    local request, job, data = bus.request, bus.job, sub(d.bytes, d.data_at + 1)
    local is_error = byte(d.bytes, 4) ~= 0

    if not request then return end
    bus.request = nil
    S.asked_answer(telegram, request, {begin = packet.time})
    telegram.job, telegram.command = job, job.command
    telegram.is_first = request.is_first
    if job.command == FETCH then
      telegram.faults.too_few_data = not is_error and #data < min(job.left, K.RK512_MOST_IN_TELEGRAM)
      if #data > 0 then take_bytes(job, telegram, data) end
    end
    if is_error then bus.job = nil end -- nothing continues it
  end

  -- The job of this telegram; found in the first pass, and kept. A repeated block is ignored.
  local function find_telegram(d, is_repeat)
    local number = packet.number
    local telegram = telegrams[number]

    if telegram then return telegram end
    telegram = S.asked_new({end_ = packet.time + (packet.record and packet.record.duration or 0)})
    telegram.is_repeat, telegram.faults = is_repeat, {}
    telegrams[number] = telegram
    if is_repeat or (d.is_cut and not d.is_snapped) then return telegram end
    if d.is_snapped then
      buses[T.bus_key()] = nil
      return telegram
    end
    if d.is_reaction then note_reaction(bus_of(), d, telegram) else note_command(bus_of(), d, telegram) end
    return telegram
  end

  local function note(d, text)
    add_expert(d.root, EX.synax_note, text)
  end

  local function show_faults(d)
    for _, fault in ipairs(faults) do
      local name, which, text = unpack(fault)

      if d.telegram.faults[name] then add_expert(d.root, which, text) end
    end
  end

  -- Data blocks that are defined, and how many words they have.
  local function check_command(d, block, count)
    if not is_data_block(byte(d.bytes, 3, 4)) then
      note(d, "SYNAX has only SEND and FETCH of data blocks (page 8-24)")
      return
    end
    if block > LONGEST_CHAIN and not S.block_text(block) then note(d, "Data block that is not defined") end
    if block == K.SYNAX_BLOCK_IO and count > K.RK512_MOST_IO_WORDS then
      note(d, "Data block 99 has at most 32 words (page 8-8)")
    end
    if block == K.SYNAX_BLOCK_MODE and count ~= 1 then note(d, "Data block 100 has one word (page 8-10)") end
    if byte(d.bytes, 6) ~= 0 then note(d, "Only whole data blocks can be accessed (page 8-7)") end
  end

  -- The coordination flag: none is FF FF in Siemens' words, SYNAX writes zeros. Both are shown, none is judged.
  local function show_command(d)
    local kind, block = byte(d.bytes, 4, 5)
    local count = word_at(d.bytes, 6)

    S.add_block(d.tree, FX.rk512i_block, d.tvb, 4)
    add(d.tree, FX.rk512i_word, d.tvb, 5, 1)
    add(d.tree, FX.rk512i_count, d.tvb, 6, 2)
    add(d.tree, FX.rk512i_flag_byte, d.tvb, 8, 1)
    add(d.tree, FX.rk512i_flag, d.tvb, 9, 1)
    d.words = d.words
      .. strformat(" DB %d, %d %s%s", block, count, IN_WORDS[kind] and "word" or "byte", plural(count))
    check_command(d, block, count)
  end

  local function show_reaction(d)
    local number, job = byte(d.bytes, 4), d.telegram.job
    local text = N.rk512_errors[number] or "Not defined"
    local item = add_value(d.tree, FX.rk512i_error, d.tvb, 3, 1, number,
      "%s (0x%02x)%s", text, number, number ~= 0 and ", by Siemens' numbers" or "")

    if job and job.ident then
      d.words = d.words .. ": " .. S.recall_head(d.tree, d.tvb, S.head_of(job.info, job.axis, job.ident))
    end
    if number == 0 then return end
    add_expert(item or d.root, EX.synax_error, strformat("Error 0x%02x: %s (Siemens' number)", number, text))
    d.words = d.words .. strformat("  [error 0x%02x: %s (Siemens' number)]", number, text)
  end

  -- All bytes of a block, or of DB nn to DB 1. Those of SEND begin with the Indramat head. A reaction has none, so
  -- its command names the parameter.
  local function show_whole(d, tree, tvb)
    local job, length = d.telegram.job, tvb:len()

    if not job.ident then
      add(tree, FX.rk512i_data, tvb, 0, length)
      if is_data_block(job.command, job.kind) then
        S.add_block_words(tree, d.root, FX.rk512i_block_word, tvb, 0, length, job.block, true)
      end
    elseif d.is_reaction then
      local head = S.head_of(job.info, job.axis, job.ident)

      d.words = d.words .. S.add_head_data(tree, d.root, tvb, 0, true, head)
    else
      local head, words = S.add_head(tree, d.root, tvb, 0, true)

      if length > K.HEAD_SIZE then words = words .. S.add_head_data(tree, d.root, tvb, K.HEAD_SIZE, true, head) end
      d.words = d.words .. ": " .. words
    end
  end

  local function show_piece(d)
    local telegram, length = d.telegram, #d.bytes - d.data_at

    add(d.tree, FX.rk512i_data, d.tvb, d.data_at, length)
    d.words = d.words .. strformat(", %s of %d bytes", telegram.is_last and "last piece" or "piece", length)
    local whole = S.put_next(d.tree, d.tvb(d.data_at, length):tvb(), telegram.job, telegram.is_last)

    if whole then show_whole(d, add_subtree(d.tree, whole, 0, whole:len(), "Data of all pieces"), whole) end
  end

  local function show_data(d)
    local telegram, length = d.telegram, #d.bytes - d.data_at
    local is_request = telegram.job and not d.is_reaction and telegram.command == FETCH

    if length == 0 then return end
    if not telegram.job or telegram.is_repeat or (is_request and not telegram.job.ident) then
      add(d.tree, FX.rk512i_data, d.tvb, d.data_at, length)
      if not telegram.job and not telegram.is_repeat then
        add_expert(d.root, EX.synax_note, "Data of a command that is not known")
      end
    elseif telegram.is_piece and not is_request then
      show_piece(d)
    else
      show_whole(d, d.tree, d.tvb(d.data_at, length):tvb())
    end
  end

  local function dissect_head(d)
    add(d.tree, FX.rk512i_follow_up, d.tvb, 0, 1)
    add(d.tree, FX.rk512i_zero, d.tvb, 1, 1)
    d.data_at = FOLLOW_UP_SIZE
    if d.is_reaction then
      d.words = d.is_follow_up and "Reaction to a follow-up" or "Reaction"
      return
    end
    add(d.tree, FX.rk512i_command, d.tvb, 2, 1)
    add(d.tree, FX.rk512i_kind, d.tvb, 3, 1)
    d.words = (N.rk512_commands[byte(d.bytes, 3)] or "Command") .. (d.is_follow_up and ", follow-up" or "")
    if d.is_follow_up then return end
    d.is_cut = #d.bytes < COMMAND_SIZE
    if d.is_cut then
      if not d.is_snapped then
        add_expert(d.root, EX.synax_short, strformat("A command has %d bytes", COMMAND_SIZE))
      end
      d.words = d.words .. "  [cut]"
      return
    end
    d.data_at = COMMAND_SIZE
    show_command(d)
  end

  local function looks_like_rk512(bytes)
    local first, second, third = byte(bytes, 1, 3)

    return #bytes >= FOLLOW_UP_SIZE and (first == 0 or first == FOLLOW_UP) and second == 0
      and (third == 0 or N.rk512_commands[third] ~= nil)
  end

  -- Decodes the data of a block; false if they do not look like RK512.
  function S.dissect_rk512i(tvb, pinfo, parent, is_repeat, is_snapped)
    local bytes = tvb:raw()

    if not looks_like_rk512(bytes) then return false end
    local tree = parent:add(rk512i, tvb())
    local d = {tvb = tvb, bytes = bytes, tree = tree, root = tree, words = "",
      is_follow_up = byte(bytes, 1) == FOLLOW_UP, is_reaction = byte(bytes, 3) == 0, is_snapped = is_snapped}

    pinfo.cols.protocol = "RK512"
    dissect_head(d)
    d.telegram = find_telegram(d, is_repeat)
    if d.is_reaction then show_reaction(d) end
    if not d.is_cut and not is_snapped then
      show_data(d)
    else
      add_bytes(tree, FX.rk512i_data, tvb, d.data_at, #bytes)
    end
    show_faults(d)
    S.asked_show(d.telegram, tree, tvb, "synax_request_in", "synax_answer_in", "synax_answer_time")
    append_text(tree, ", " .. d.words)
    pinfo.cols.info:append("  " .. d.words)
    return true
  end

  function rk512i.dissector(tvb, pinfo, parent)
    if not packet.record or packet.number ~= pinfo.number then look_at(pinfo) end
    pinfo.cols.info = ""
    local captured, there = tvb:len(), tvb:reported_len()
    local is_snapped = captured < there

    if captured >= min(there, FOLLOW_UP_SIZE) and not S.dissect_rk512i(tvb, pinfo, parent, false, is_snapped) then
      return 0
    end
    if is_snapped then S.show_cut(tvb, pinfo, parent, "RK512I") end
    return tvb:len()
  end
end

--- rk512/3964r: 3964R, Siemens' procedure between two partners (chapter 8). STX asks to send, DLE grants; then the
-- block, every DLE in it doubled, DLE ETX and the check character BCC; DLE says that it came well, NAK that it did not.
-- A packet is one of these: a character alone, or a block without its STX.


do
  local STX, ETX, DLE, NAK = K.P3964R_STX, 0x03, K.P3964R_DLE, K.P3964R_NAK
  local END_SIZE = 3 -- DLE ETX BCC
  local MS = 1000000 -- in ns
  local ASKS, BOTH_ASK, GRANTS = K.P3964R_ASKS, K.P3964R_BOTH_ASK, K.P3964R_GRANTS
  local REFUSES_REQUEST, BLOCK, ACKNOWLEDGES = K.P3964R_REFUSES_REQUEST, K.P3964R_BLOCK, K.P3964R_ACKNOWLEDGES
  local REFUSES_BLOCK, OUT_OF_PLACE = K.P3964R_REFUSES_BLOCK, K.P3964R_OUT_OF_PLACE
  local CHECKSUM_BAD, CHECKSUM_GOOD = 0, 1
  local names = {[STX] = "STX", [DLE] = "DLE", [NAK] = "NAK"}

  -- A character or block, what it asks and answers, and {meaning, repeat_of, unanswered: frames, tries}. Of both
  -- partners: {request, block: that wait for their answer, rival: the
  -- partner's request meanwhile, granted: whose block has not come, refused, last_block (nil: accepted, or given up),
  -- tries: to send it, sender: its line, is_asked_again: since that try, finish: of the last unit}.
  local buses, units

  at_init(function() buses, units = {}, {} end)

  local function end_series(bus)
    bus.last_block, bus.tries = nil, 0 -- the same bytes again would be a new block
  end

  -- The next try to send, if the same partner has asked again, whatever the bytes. Who gives way to the other begins
  -- anew.
  local function count_try(bus, line, is_same)
    local is_next = (bus.tries or 0) > 0 and bus.sender == line and (is_same or bus.is_asked_again)

    bus.tries = is_next and bus.tries + 1 or 1
    bus.sender, bus.is_asked_again = line, false
    return bus.tries
  end

  -- Two requests within QVZ come from both partners, if possible: then neither was answered.
  local function note_request(bus, unit, times)
    local before, limit_ms = bus.request, p3964r.prefs.qvz_ms
    local tried, qvz = before, (limit_ms > 0 and limit_ms or K.P3964R_QVZ_MS) * MS
    local is_soon = before and T.elapsed(before.finish, times.begin) < qvz
    -- The partners give up when nothing comes for the block wait, or after QVZ, if that is set to more.
    local is_over = bus.finish and T.elapsed(bus.finish, times.begin) > max(K.P3964R_BLOCK_WAIT_MS * MS, 2 * qvz)

    unit.meaning, unit.tries = ASKS, 1
    -- Perhaps for the last block. On a line that both share, only the partner asks before QVZ is over.
    bus.is_asked_again = unit.line ~= 0 or not bus.block or T.elapsed(bus.block.finish, times.begin) >= qvz
    bus.granted = nil
    if is_over then end_series(bus) end
    if is_soon and (unit.line == 0 or unit.line ~= before.line) then
      unit.meaning, bus.rival = BOTH_ASK, unit
      bus.is_asked_again = unit.line ~= 0 -- on one line, nobody sees who gives way
      return -- the first request still waits
    end
    if before then
      unit.unanswered = before.frame
    elseif bus.refused and bus.refused.meaning ~= BLOCK then
      tried = bus.refused
    end
    if tried and tried.line == unit.line and not is_over then unit.tries = tried.tries + 1 end
    if bus.block then unit.unanswered = bus.block.frame end
    bus.block, bus.rival, bus.refused, bus.request = nil, nil, nil, unit
  end

  local function note_answer(bus, unit, times, is_good)
    local asked = S.may_answer(unit, bus.request) and bus.request or bus.rival

    if S.may_answer(unit, asked) then
      unit.meaning = is_good and GRANTS or REFUSES_REQUEST
      bus.granted = is_good and asked or nil
      bus.request, bus.rival = nil, nil
    elseif S.may_answer(unit, bus.block) then
      asked = bus.block
      unit.meaning = is_good and ACKNOWLEDGES or REFUSES_BLOCK
      if is_good then end_series(bus) end
      bus.block = nil
    elseif not is_good and S.may_answer(unit, bus.granted) then -- a block that broke off: no frame
      unit.meaning = REFUSES_BLOCK
      count_try(bus, bus.granted.line, false)
      bus.granted = nil
      return
    else
      unit.meaning = OUT_OF_PLACE
      return
    end
    S.asked_answer(unit, asked, times)
    bus.refused = not is_good and asked or nil
  end

  local function note_block(bus, unit, bytes, is_whole)
    local last = bus.last_block
    local is_same = is_whole and last and last.line == unit.line and last.bytes == bytes

    unit.meaning, unit.tries = BLOCK, count_try(bus, unit.line, is_same)
    if is_same then
      unit.repeat_of = last.repeat_of or last.frame
      last.bytes = nil
    end
    unit.bytes = is_whole and bytes -- otherwise the rest may differ: no block is the same
    bus.request, bus.rival, bus.granted, bus.refused = nil, nil, nil, nil
    bus.block, bus.last_block = unit, unit
  end

  -- The meaning of a unit depends on what came before it; found in the first pass, and kept.
  local function find_unit(bytes, there, times)
    local number, character = packet.number, byte(bytes, 1)
    local unit = units[number]

    if unit then return unit end
    unit = S.asked_new(times)
    units[number] = unit
    local key = T.bus_key()

    buses[key] = buses[key] or {}
    if there > 1 then
      note_block(buses[key], unit, bytes, #bytes == there)
    elseif character == STX then
      note_request(buses[key], unit, times)
    elseif character == DLE or character == NAK then
      note_answer(buses[key], unit, times, character == DLE)
    else
      unit.meaning = OUT_OF_PLACE
    end
    buses[key].finish = unit.finish
    return unit
  end

  local function show_verdict(d, limit_field, verdict_field, limit_ms, verdict, words)
    S.add_time(d.tree, limit_field, d.tvb, limit_ms * MS, "%s ms", limit_ms)
    local item = add_generated(d.tree, verdict_field, d.tvb, verdict)

    if verdict == K.TIME_OK then return end
    local is_exceeded = verdict == K.TIME_EXCEEDED

    add_expert(item or d.root, is_exceeded and EX["3964r_exceeded"] or EX["3964r_unresolved"], words)
    if is_exceeded then d.cols.info:append("  [" .. words .. "]") end
  end

  -- How long the partner took, against the acknowledgment delay QVZ.
  local function show_answer(d)
    local unit, limit = d.unit, p3964r.prefs.qvz_ms

    if not unit.request_in then return end
    add_generated(d.tree, FX["3964r_answers"], d.tvb, unit.request_in)
    S.add_ms(d.tree, FX["3964r_answer_time"], d.tvb, unit.elapsed)
    if d.times.record and limit > 0 then
      show_verdict(d, FX["3964r_qvz_limit"], FX["3964r_qvz_verdict"], limit, S.judge(unit.span, limit * MS),
        strformat("answered later than QVZ = %d ms", limit))
    end
  end

  -- The longest interval inside a block, against the character delay ZVZ.
  local function show_intervals(d)
    local limit = p3964r.prefs.zvz_ms
    local longest = d.times.record and S.longest(d.times, limit * MS, K.FROM_START)

    if not longest then return end
    local interval = longest.interval
    local shown = (interval.is_exact or interval.is_saturated) and interval.recorded or interval.span.most

    if shown ~= K.ANY_TIME then
      S.add_ms(d.tree, FX["3964r_zvz_interval_max"], d.tvb, shown, interval.is_saturated)
    end
    add_generated(d.tree, FX["3964r_zvz_position"], d.tvb, interval.at)
    if limit > 0 then
      show_verdict(d, FX["3964r_zvz_limit"], FX["3964r_zvz_verdict"], limit, longest.verdict,
        strformat("an interval longer than ZVZ = %d ms", limit))
    end
  end

  local function show_unit(d)
    local unit, root = d.unit, d.root

    add_generated(d.tree, FX["3964r_answer_in"], d.tvb, unit.answer_in)
    add_generated(d.tree, FX["3964r_repeat_of"], d.tvb, unit.repeat_of)
    add_generated(d.tree, FX["3964r_unanswered_before"], d.tvb, unit.unanswered)
    add_generated(d.tree, FX["3964r_try"], d.tvb, unit.tries)
    if unit.meaning == BOTH_ASK then add_expert(root, EX["3964r_conflict"]) end
    if unit.meaning == OUT_OF_PLACE then add_expert(root, EX["3964r_unexpected"]) end
    if unit.meaning == REFUSES_REQUEST or unit.meaning == REFUSES_BLOCK then add_expert(root, EX["3964r_refused"]) end
    if unit.unanswered then add_expert(root, EX["3964r_unanswered"]) end
    if unit.repeat_of then add_expert(root, EX["3964r_repeat"]) end
    if (unit.tries or 0) > K.P3964R_MOST_TRIES then add_expert(root, EX["3964r_tries"]) end
  end

  local function block_check(bytes, first, last)
    local bcc = 0

    for at = first, last do
      bcc = bxor(bcc, byte(bytes, at))
    end
    return bcc
  end

  -- Data without doubled DLEs, and how many were doubled; nil if one is not doubled.
  local function undouble(bytes)
    local parts, doubled, at = {}, 0, 1

    while true do
      local found = string.find(bytes, char(DLE), at, true)

      if not found then break end
      if byte(bytes, found + 1) ~= DLE then return nil end
      parts[#parts + 1] = sub(bytes, at, found)
      doubled, at = doubled + 1, found + 2
    end
    parts[#parts + 1] = sub(bytes, at)
    return concat(parts), doubled
  end

  local function show_check(d, first, finish)
    local bytes, at = d.bytes, finish + END_SIZE
    local bcc, expected = byte(bytes, at), block_check(bytes, first, at - 1)
    local state = bcc == expected and CHECKSUM_GOOD or CHECKSUM_BAD

    add(d.tree, FX["3964r_end"], d.tvb, finish, 2)
    local item = add(d.tree, FX["3964r_bcc"], d.tvb, at - 1, 1)

    set_generated(add_value(d.tree, FX["3964r_bcc_status"], d.tvb, at - 1, 0, state, N.checksum_states[state]))
    if state == CHECKSUM_GOOD then
      append_text(item, " [correct]")
      return true
    end
    append_text(item, strformat(" incorrect, should be 0x%02x", expected))
    add_expert(item or d.root, EX["3964r_bcc_bad"])
    d.cols.info:append("  [wrong BCC]")
    return false
  end

  local function dissect_block(d, pinfo, parent)
    local bytes, there = d.bytes, #d.bytes
    local finish, first = there - END_SIZE, 1
    local data, doubled

    if d.is_cut then
      add(d.tree, FX["3964r_raw"], d.tvb, 0, there)
      d.cols.info:append("Block")
      return
    end

    if finish >= 0 and byte(bytes, finish + 1) == DLE and byte(bytes, finish + 2) == ETX then
      -- Another logger's block may include its STX: then the check character decides.
      local bcc = byte(bytes, there)

      local has_stx = byte(bytes, 1) == STX and block_check(bytes, 1, there - 1) ~= bcc

      if has_stx and block_check(bytes, 2, there - 1) == bcc then first = 2 end
      data, doubled = undouble(sub(bytes, first, finish))
    end
    if not data then
      add(d.tree, FX["3964r_raw"], d.tvb, 0, there)
      add_expert(d.root, EX["3964r_broken"])
      d.cols.info:append(strformat("Broken-off block, %d bytes", there))
      return
    end
    d.cols.info:append(strformat("Block, %d byte%s%s", #data, plural(#data), d.unit.repeat_of and "  [repeat]" or ""))
    if first > 1 then add(d.tree, FX["3964r_character"], d.tvb, 0, 1) end
    local size = finish - first + 1

    set_generated(add(d.tree, FX["3964r_length"], d.tvb, first - 1, size, #data))
    if doubled > 0 then set_generated(add(d.tree, FX["3964r_doubled"], d.tvb, first - 1, size, doubled)) end
    local is_good = show_check(d, first, finish)

    if #data == 0 then return end
    local tvb = doubled > 0 and ByteArray.new(data, true):tvb("Block without doubled DLEs")
      or d.tvb(first - 1, size):tvb()

    if is_good and S.dissect_rk512i(tvb, pinfo, parent, d.unit.repeat_of ~= nil) then return end
    add(d.tree, FX["3964r_data"], tvb, 0, tvb:len())
  end

  local function dissect_character(d)
    local character = byte(d.bytes, 1)

    add(d.tree, FX["3964r_character"], d.tvb, 0, 1)
    d.cols.info:append((names[character] or "Character") .. "  " .. N.procedure_meanings[d.unit.meaning])
  end

  function p3964r.dissector(tvb, pinfo, parent)
    if tvb:reported_len() == 0 then return 0 end
    local bytes, tree = tvb:raw(), parent:add(p3964r, tvb())

    if not packet.record or packet.number ~= pinfo.number then look_at(pinfo) end
    pinfo.cols.protocol = "3964R"
    pinfo.cols.info = ""
    local there = T.reported_len(tvb)
    if #bytes == 0 then
      if there > 0 then S.show_cut(tvb, pinfo, parent, "3964R") end
      return
    end
    local times = S.times(tvb, there, there)
    local d = {tvb = tvb, bytes = bytes, tree = tree, root = tree, cols = pinfo.cols, times = times,
      is_cut = #bytes < there, unit = find_unit(bytes, there, times)}

    append_text(tree, ", " .. N.procedure_meanings[d.unit.meaning])
    if d.unit.meaning == BLOCK then dissect_block(d, pinfo, parent) else dissect_character(d) end
    add_generated(tree, FX["3964r_meaning"], tvb, d.unit.meaning)
    show_unit(d)
    show_answer(d)
    if d.unit.meaning == BLOCK then show_intervals(d) end
    if d.is_cut then S.show_cut(tvb, pinfo, parent, "3964R") end
  end
end

--- synax/ways: from one station to another, on a line of the capture

function S.way_key(from, to)
  local of_section, of_interface = S.place()

  return strformat("%d/%d/%s/%s", of_section, of_interface, tostring(from), tostring(to))
end

--- synax/arcnet7f: the data exchange protocol on ARCNET, protocol id 0x7F (chapter 7): TO sends data, FETCH asks for
-- them, and only FETCH is answered, by a TO (page 7-3).

do
  local PROTOCOL_ID, TO, FETCH, WORD_ARRAY = 0x7F, K.ARCNET7F_TO, K.ARCNET7F_FETCH, K.ARCNET7F_WORD_ARRAY
  local SHORT_HEAD, HEAD, BLOCK_AT = 7, 13, 9
  local FIRST_MESSAGE, FOLLOW_UP_MESSAGES, FOLLOW_UP_MESSAGE_END = 0x8010, 0x1C20, 0x1CFF
  local INFO_WRITE, INFO_BLOCK = K.SYNAX_INFO_WRITE, 0x0040
  local CANCEL_BLOCK = 98
  local LENGTH_WORDS = 4

  local frame_field = Field.new("frame")
  local ways, kept_of -- from one station to another; what is kept, by packet

  at_init(function() ways, kept_of = {}, {} end)

  local function byte_at(t, offset)
    return byte(t.bytes, offset + 1)
  end

  local function word_at(t, offset)
    return S.little_endian(t.bytes, offset + 1, 2)
  end

  local function say(t, ...)
    t.words = t.words .. strformat(...)
  end

  local function mark(t, item, which, ...)
    add_expert(item or t.root, which, strformat(...))
  end

  -- Not documented.
  local function give_up(t, text)
    add_bytes(t.tree, F.raw, t.tvb, SHORT_HEAD, t.end_)
    mark(t, nil, EX.synax_note, "%s", text)
    say(t, "%s%s", t.words ~= "" and ": " or "", text)
  end

  local short_head = {
    {FX.arcnet7f_id, 1}, {FX.arcnet7f_message, 2}, {FX.arcnet7f_command, 1}, {FX.arcnet7f_type, 1},
    {FX.arcnet7f_length, 2},
  }

  -- The seven bytes that every telegram has, as far as they are there.
  local function add_short_head(t)
    local offset = 0

    for _, part in ipairs(short_head) do
      if offset + part[2] > t.end_ then break end
      add_le(t.tree, part[1], t.tvb, offset, part[2])
      offset = offset + part[2]
    end
    if offset == SHORT_HEAD then return true end
    add_bytes(t.tree, F.raw, t.tvb, offset, t.end_)
    if t.whole < SHORT_HEAD then mark(t, nil, EX.synax_short, "The head is cut") end
    say(t, "Cut telegram")
    return false
  end

  local function read_extent(t)
    local there = t.whole - SHORT_HEAD

    t.declared = 2 * word_at(t, 5)
    if t.command == FETCH and not (t.is_follow_up and t.declared == 0) then t.declared = K.HEAD_SIZE end
    t.is_short = t.declared > there
    t.whole = SHORT_HEAD + min(t.declared, there)
    t.is_cut = t.end_ < t.whole
    t.end_ = min(t.end_, t.whole)
  end

  local function check_extent(t)
    local there = t.there

    if t.is_short then mark(t, nil, EX.synax_short, "Fewer bytes than the length says") end
    if there > t.whole then
      add_bytes(t.tree, F.raw, t.tvb, t.end_, #t.bytes)
      mark(t, nil, EX.synax_unexpected, "Bytes after the telegram")
    end
  end

  local function find_way(from, to)
    local key = S.way_key(from, to)

    ways[key] = ways[key] or {}
    return ways[key]
  end

  -- What a telegram is about, the same in a FETCH and in its answer.
  local function subject_of(t)
    if t.is_follow_up then return sub(t.bytes, 2, 3) end
    return band(byte_at(t, SHORT_HEAD), INFO_WRITE) .. "/" .. sub(t.bytes, BLOCK_AT + 1, BLOCK_AT + 4)
  end

  -- The number of bytes of a list by its length words; 0: it has none, or they are wrong.
  local function announced_by(t)
    if t.is_block or t.end_ < HEAD + LENGTH_WORDS or not S.is_parameter(word_at(t, SHORT_HEAD)) then return 0 end
    local actual = word_at(t, HEAD)

    return actual <= word_at(t, HEAD + 2) and actual + LENGTH_WORDS or 0
  end

  local function begin_transfer(t, way)
    local announced, is_last = announced_by(t), band(byte_at(t, SHORT_HEAD), K.SYNAX_INFO_LAST) ~= 0

    if t.is_block and byte_at(t, BLOCK_AT) == CANCEL_BLOCK or t.is_cut and not is_last then way.transfer = nil end
    if t.is_short or t.is_cut or announced <= t.end_ - HEAD
      or (is_last and way.transfer and not way.transfer.is_last) then
      return
    end
    way.transfer = {
      ident = S.ident(byte_at(t, 10), word_at(t, 11)),
      is_last = is_last,
      begun_in = packet.number,
      announced = announced,
      received = t.end_ - HEAD,
      pieces = {},
    }
    t.kept.transfer = way.transfer
    S.add_piece(way.transfer, sub(t.bytes, HEAD + 1, t.end_), false)
  end

  local function continue_transfer(t, way)
    local transfer, message = way.transfer, word_at(t, 1)

    if not transfer then return end
    if t.is_short or t.is_cut then
      way.transfer = nil
      return
    end
    t.kept.transfer = transfer
    local before = message > FOLLOW_UP_MESSAGES and message - 1 or FOLLOW_UP_MESSAGE_END -- pages 7-20 and 7-27

    t.kept.is_out_of_order = transfer.message and transfer.message ~= before
    transfer.message = message
    transfer.received = transfer.received + t.end_ - SHORT_HEAD
    t.kept.is_last_piece = transfer.received >= transfer.announced
    if t.kept.is_last_piece then way.transfer = nil end
    S.add_piece(transfer, sub(t.bytes, SHORT_HEAD + 1, t.end_), t.kept.is_last_piece)
  end

  -- First pass: the request that it answers, and the list that it continues.
  local function follow(t)
    local from, to = t.pinfo.src, t.pinfo.dst
    local way, back = find_way(from, to), find_way(to, from)

    effects = effects + 1
    if t.command == FETCH then
      t.kept.unanswered_in = way.request and way.request.frame
      way.request, way.subject = t.kept, subject_of(t)
      return
    end
    if back.request and back.subject == subject_of(t) then
      S.asked_answer(t.kept, back.request, {begin = packet.time})
      back.request = nil
    end
    if t.is_follow_up then continue_transfer(t, way) else begin_transfer(t, way) end
  end

  local function show_links(t)
    local kept = t.kept

    S.asked_show(kept, t.tree, t.tvb, "synax_request_in", "synax_answer_in", "synax_answer_time")
    add_generated(t.tree, FX.synax_unanswered_in, t.tvb, kept.unanswered_in)
    if kept.unanswered_in then add_expert(t.root, EX.synax_unanswered_before) end
  end

  local function say_bytes(t, count)
    say(t, ", %d byte%s", count, plural(count))
  end

  -- An answer, too, is a TO.
  local function check_data(t)
    if t.command == TO and t.whole == HEAD and not t.is_short then
      mark(t, nil, EX.synax_short, "A TO sends data (page 7-3)")
    end
  end

  local function add_block_data(t, block)
    if block ~= CANCEL_BLOCK then check_data(t) end
    add_bytes(t.tree, F.data, t.tvb, HEAD, t.end_)
    if t.whole == HEAD then return end
    S.add_block_words(t.tree, t.root, FX.arcnet7f_word, t.tvb, HEAD, t.end_, block, false)
    if block == K.SYNAX_BLOCK_MODE and t.whole - HEAD > 2 then
      mark(t, nil, EX.synax_note, "Data block 100 has one word (page 7-15)")
    end
    say_bytes(t, t.whole - HEAD)
  end

  local function add_block(t)
    local block = byte_at(t, BLOCK_AT)
    local text = S.block_text(block)

    S.add_info(t.tree, t.root, t.tvb, SHORT_HEAD, false, INFO_BLOCK)
    local item = S.add_block(t.tree, FX.arcnet7f_block, t.tvb, BLOCK_AT)

    if not text then mark(t, item, EX.synax_note, "Data block that is not defined") end
    if sub(t.bytes, BLOCK_AT + 2, HEAD) ~= "\0\0\0" then
      add_bytes(t.tree, F.raw, t.tvb, BLOCK_AT + 1, HEAD)
      mark(t, nil, EX.synax_note, "Content after the number of a data block")
    end
    say(t, "%s DB %d%s", band(byte_at(t, SHORT_HEAD), INFO_WRITE) ~= 0 and "Write" or "Read", block,
      text and " (" .. text .. ")" or "")
    add_block_data(t, block)
  end

  local function add_length_words(t)
    add_le(t.tree, FX.arcnet7f_list_actual, t.tvb, HEAD, 2)
    add_le(t.tree, FX.arcnet7f_list_maximum, t.tvb, HEAD + 2, 2)
  end

  -- A list that is whole in its first telegram (page 7-28), in whole words as add_whole() has them. Values that an
  -- attribute describes show their length words themselves.
  local function add_whole_list(t, announced, head)
    local list, offset, has_attribute = t.tvb(0, HEAD + announced):tvb(), HEAD, head.known.attribute

    say(t, (announced > LENGTH_WORDS or has_attribute) and ", list" or ", empty list")
    if not has_attribute then
      add_length_words(t)
      offset = HEAD + LENGTH_WORDS
    end
    say(t, "%s", S.add_head_data(t.tree, t.root, list, offset, false, head))
    add_bytes(t.tree, F.raw, t.tvb, HEAD + announced, t.end_)
  end

  local function add_first_piece(t, announced)
    local here = t.end_ - HEAD - LENGTH_WORDS

    add_length_words(t)
    add_bytes(t.tree, F.data, t.tvb, HEAD + LENGTH_WORDS, t.end_)
    say(t, ", list of %d bytes, %d here", announced - LENGTH_WORDS, here)
  end

  local function add_parameter(t)
    local head, words = S.add_head(t.tree, t.root, t.tvb, SHORT_HEAD, false)
    local announced, length = announced_by(t), t.end_ - HEAD

    say(t, "%s", words)
    if t.command == FETCH then return end
    if t.is_cut then
      say_bytes(t, t.whole - HEAD)
      add_bytes(t.tree, F.data, t.tvb, HEAD, t.end_)
      return
    end
    if not head.is_parameter or head.is_last then
      check_data(t)
      local telegram = t.end_ == #t.bytes and t.tvb or t.tvb(0, t.end_):tvb()

      say(t, "%s", S.add_head_data(t.tree, t.root, telegram, HEAD, false, head))
    elseif announced > 0 and announced + announced % 2 == length then
      add_whole_list(t, announced, head)
    elseif announced > length then
      add_first_piece(t, announced)
    else
      say_bytes(t, length)
      add_bytes(t.tree, F.data, t.tvb, HEAD, t.end_)
      mark(t, nil, EX.synax_note, "More is to follow, but the data do not begin with the lengths of a list")
    end
    if t.kept.transfer then S.put_next(t.tree, t.tvb(HEAD, length):tvb(), t.kept.transfer, false) end
  end

  local function add_first(t)
    if t.end_ < HEAD then
      add_bytes(t.tree, F.raw, t.tvb, SHORT_HEAD, t.end_)
      say(t, "Cut telegram")
      if not t.is_short and not t.is_cut then
        mark(t, nil, EX.synax_short, "The length is shorter than the head")
      end
    elseif t.is_block then
      add_block(t)
    else
      add_parameter(t)
    end
  end

  local function add_whole(t, whole)
    local transfer, length = t.kept.transfer, whole:len()
    local head = S.head_of(0, 0, transfer.ident)

    say(t, "; whole")
    if length > transfer.announced + 1 then
      mark(t, nil, EX.synax_unexpected, "More bytes than the list announces")
    end
    local part = length > transfer.announced and whole(0, transfer.announced):tvb() or whole

    say(t, "%s", S.add_head_data(t.tree, t.root, part, 0, false, head))
  end

  local function add_request_of_piece(t)
    if t.end_ < HEAD then
      add_bytes(t.tree, F.raw, t.tvb, SHORT_HEAD, t.end_)
      return
    end
    local _, words = S.add_head(t.tree, t.root, t.tvb, SHORT_HEAD, false)

    say(t, ": %s", words)
  end

  local function add_follow_up(t)
    local transfer, length = t.kept.transfer, t.end_ - SHORT_HEAD

    say(t, "Follow-up 0x%04x", word_at(t, 1))
    if t.command == FETCH then
      add_request_of_piece(t)
      return
    end
    if transfer then
      add_generated(t.tree, FX.arcnet7f_first_in, t.tvb, transfer.begun_in)
      if t.tree then
        S.add_ident(t.tree, t.tvb, {offset = 0, length = 0}, transfer.ident, S.known_from_tables(transfer.ident))
      end
      say(t, " of %s", transfer.ident.text)
    end
    add_bytes(t.tree, F.data, t.tvb, SHORT_HEAD, t.end_)
    say_bytes(t, t.whole - SHORT_HEAD)
    if t.is_cut then return end
    if not transfer then
      mark(t, nil, EX.synax_note, "No list goes on here: its beginning is missing, or it has ended")
      return
    end
    if t.kept.is_out_of_order then
      mark(t, nil, EX.synax_note, "Its message number does not follow that of the piece before")
    end
    local piece = length > 0 and t.tvb(SHORT_HEAD, length):tvb() or t.tvb
    local whole = S.put_next(t.tree, piece, transfer, t.kept.is_last_piece)

    if whole then add_whole(t, whole) end
  end

  -- After the first seven bytes.
  local function add_rest(t)
    local message = word_at(t, 1)

    t.command = byte_at(t, 3)
    t.is_follow_up = message >= FOLLOW_UP_MESSAGES and message <= FOLLOW_UP_MESSAGE_END
    if byte_at(t, 0) ~= PROTOCOL_ID then return give_up(t, "not the protocol 0x7f") end
    if t.command > FETCH then return give_up(t, "command that is not defined") end
    say(t, t.command == TO and "TO" or "FETCH")
    if message ~= FIRST_MESSAGE and not t.is_follow_up then
      return give_up(t, "message number that is not defined")
    end
    if byte_at(t, 4) ~= WORD_ARRAY then return give_up(t, "data type that is not defined") end
    say(t, "  ")
    read_extent(t)
    t.is_block = not t.is_follow_up and t.end_ > SHORT_HEAD and band(byte_at(t, SHORT_HEAD), INFO_BLOCK) ~= 0
    if not packet.visited and (t.is_follow_up or t.end_ >= HEAD) then follow(t) end
    show_links(t)
    if t.is_follow_up then add_follow_up(t) else add_first(t) end
    check_extent(t)
  end

  -- `tvb` is what the capture has of a packet of `there` bytes.
  local function dissect(tvb, pinfo, parent, there)
    local tree = parent:add(arcnet7f, tvb())
    local bytes = tvb:raw()
    local t = {tvb = tvb, bytes = bytes, pinfo = pinfo, tree = tree, root = tree, words = "", there = there,
      whole = there, end_ = #bytes}

    kept_of[packet.number] = kept_of[packet.number] or S.asked_new({end_ = packet.time})
    t.kept = kept_of[packet.number]
    if add_short_head(t) then add_rest(t) end
    pinfo.cols.info = t.words
    append_text(t.root, ", " .. t.words)
    if #bytes < there then S.show_cut(tvb, pinfo, parent, "ARCNET7F") end
  end

  -- Wireshark takes the three bytes after the protocol id as its split flag and sequence number; seven bytes if the
  -- first is 0xFF and the link type is BSD's. Only the field of the whole packet has them.
  function arcnet7f.dissector(tvb, pinfo, parent)
    S.begin_packet(pinfo)
    pinfo.cols.protocol = "ARCNET7F"
    pinfo.cols.info = ""
    if pinfo.match ~= PROTOCOL_ID then return dissect(tvb, pinfo, parent, tvb:reported_len()) end
    local frame, offset = frame_field(), tvb:offset()
    local begin = offset == 10 and 2 or max(offset, 4) - 4

    if frame then dissect(frame.range(begin):tvb(), pinfo, parent, offset + tvb:reported_len() - begin) end
  end

  DissectorTable.get("arcnet.protocol_id"):add(PROTOCOL_ID, arcnet7f)
end

--- synax/synaxpk: the parameter channel in the cyclic data of Profibus: six words, the first of which is the control
-- word FBSteuer or the status word FBStatus (chapter 3).

do
  local CHANNEL_SIZE, WORD_SIZE = 12, 2
  local BASIC_STATE = 0x000F
  local OPEN_BITS, ERROR_BIT, READ_BIT = K.SYNAXPK_WORD_OPEN, K.SYNAXPK_WORD_ERROR, K.SYNAXPK_WORD_READ
  local BUSY_BIT, LAST_BIT = K.SYNAXPK_WORD_BUSY, K.SYNAXPK_WORD_LAST
  local DRIVE_SHORT_1, A_SHORT_1, SIS_FORMAT = 0x0, 0x1, 0xB
  local BUSY_CODE, SERIAL_ERRORS, TELEGRAM_START = 0x0008, 0x01, 0x02
  local DRIVE_PF_BIT, DRIVE_ERROR_BIT = K.SYNAXPK_DRIVE_PF, K.SYNAXPK_DRIVE_ERROR
  local DRIVE_LAST_BIT = K.SYNAXPK_DRIVE_LAST
  local FIRST_S_INDEX, S_INDEX_END, ORDER_HEAD_END = 0x2000, 0x3000, 6 -- the last: of the word, index and subindex
  local SYNAX = 0 -- a layout; IndraDrive's is 1
  local GUESS, MASTER, SLAVE = 0, K.SYNAXPK_MASTER, K.SYNAXPK_SLAVE
  local SENT, RECEIVED = 0, 1 -- pinfo.p2p_dir

  local ways, kept_of -- data under way in one direction; what is kept, by packet

  at_init(function() ways, kept_of = {}, {} end)

  local function big_endian(bytes, offset)
    return byte(bytes, offset + 1) * 0x100 + byte(bytes, offset + 2)
  end

  local function has(c, bits)
    return band(c.word, bits) ~= 0
  end

  local function mark(c, item, which, ...)
    add_expert(item or c.root, which, strformat(...))
  end

  local function say(c, text)
    c.words = c.words .. (c.words ~= "" and ", " or "") .. text
  end

  local function say_bytes(c, count)
    say(c, strformat("%d byte%s", count, plural(count)))
  end

  -- Bytes without a documented meaning: each with its number, counted from byte 0 of `tvb`.
  local function add_open_bytes(c, tvb, offset, stop, why)
    if offset >= stop then return end
    local tree = add(c.tree, F.raw, tvb, offset, stop - offset) or c.tree

    for at = offset, stop - 1 do
      local value = tvb(at, 1):uint()

      add(tree, FX.synaxpk_byte, tvb, at, 1, value, strformat("Byte %d: 0x%02x", at, value))
    end
    if why then mark(c, tree, EX.synax_note, "%s", why) end
  end

  local function add_sender(c)
    local sender = synaxpk.prefs.direction

    if sender == GUESS then
      sender = c.pinfo.p2p_dir == SENT and MASTER or c.pinfo.p2p_dir == RECEIVED and SLAVE or GUESS
    end
    c.sender = sender
    if sender == GUESS then return end
    add_generated(c.tree, FX.synaxpk_sender, c.tvb, sender)
    c.words = N.channel_senders[sender]
  end

  -- FLP does not count the control word. If two bytes more than counted would fit SYNAX, there is no note: its
  -- printed error answers can be read both ways.
  local function read_extent(c)
    local count, there = band(rshift(c.word, 4), 0xF), c.there - WORD_SIZE

    c.end_ = WORD_SIZE + min(count, there)
    if count > K.SYNAXPK_MOST_DATA then
      mark(c, nil, EX.synax_note, "The channel has 10 bytes of data, its word says more")
    elseif there + WORD_SIZE < count then
      c.is_short = true
      mark(c, nil, EX.synax_short, "The data are cut")
    end
  end

  -- Of a sender; if that is unknown, of the access: read data come from the slave, written data from the master (FLP,
  -- page 11-12).
  local function find_key(c, whose)
    local key = S.way_key(c.pinfo.src, c.pinfo.dst) .. "/" .. whose

    ways[key] = ways[key] or {}
    return key
  end

  -- First pass: cyclic data stay as they are until they change, and the toggle bit changes with every fragment.
  local function follow(c, kept)
    local way = ways[find_key(c, c.sender ~= GUESS and c.sender or band(c.word, READ_BIT))]
    local image, is_last = sub(c.bytes, 1, c.there), has(c, LAST_BIT)

    effects = effects + 1
    kept.is_repeated = way.image == image
    way.image = image
    if kept.is_repeated then return end
    if c.is_short then
      way.transfer = nil
      return
    end
    if not is_last and not way.transfer then way.transfer = {pieces = {}} end
    kept.transfer = way.transfer
    if is_last then way.transfer = nil end
    if kept.transfer then S.add_piece(kept.transfer, sub(c.bytes, WORD_SIZE + 1, c.end_), is_last) end
  end

  -- First pass: forgets what was under way.
  local function forget(c)
    if c.sender ~= GUESS then
      ways[find_key(c, c.sender)] = {}
    else
      ways[find_key(c, 0)], ways[find_key(c, READ_BIT)] = {}, {}
    end
  end

  -- First pass: data are repeated only if their sender has sent nothing else since. If the sender is unknown, only
  -- the basic state shows that they are new.
  local function follow_word(c)
    if c.word == BASIC_STATE then forget(c) end
    if c.sender ~= GUESS then ways[find_key(c, c.sender)].image = sub(c.bytes, 1, c.there) end
  end

  local function add_parameter(c)
    local ident = S.ident(band(c.word, 0xF) == A_SHORT_1 and 1 or 0, big_endian(c.bytes, WORD_SIZE))
    local known = S.known_from_tables(ident)

    if c.tree then
      S.add_ident(c.tree, c.tvb, {offset = WORD_SIZE, length = 2, number_at = WORD_SIZE, is_big = true}, ident, known)
    end
    say(c, ident.text .. (known.name and " (" .. known.name .. ")" or ""))
  end

  -- Class and code together are the error code of SIS, and 00, 08 means busy (pages 3-8 and 3-9).
  local function add_class_and_code(c)
    local code = big_endian(c.bytes, 4)
    local text = N.errors_parameter[code] or "Not defined"

    add(c.tree, FX.synaxpk_class, c.tvb, 4, 1)
    local item = add(c.tree, FX.synaxpk_class_code, c.tvb, 5, 1)

    if not has(c, ERROR_BIT) then
      append_text(item, " (busy)")
      return
    end
    item = add_value(c.tree, F.error, c.tvb, 4, 2, code, "%s (0x%04x)", text, code)
    mark(c, item, EX.synax_error, "error 0x%04x: %s", code, text)
    say(c, strformat("error 0x%04x: %s", code, text))
  end

  local function is_busy(c)
    return not has(c, ERROR_BIT) and has(c, BUSY_BIT) and c.end_ >= 6 and big_endian(c.bytes, 4) == BUSY_CODE
  end

  local function add_short_answer(c)
    say(c, has(c, ERROR_BIT) and "error" or "busy")
    if c.end_ < 4 then
      add_open_bytes(c, c.tvb, WORD_SIZE, c.end_)
      mark(c, nil, EX.synax_short, "Parameter number missing")
      return
    end
    add_parameter(c)
    if c.end_ < 6 then
      add_open_bytes(c, c.tvb, 4, c.end_)
      mark(c, nil, EX.synax_short, "Error code missing")
      return
    end
    add_class_and_code(c)
    add_open_bytes(c, c.tvb, 6, c.end_, "What follows the error code is not defined")
  end

  local function add_short_1(c)
    if has(c, ERROR_BIT) or is_busy(c) then return add_short_answer(c) end
    say_bytes(c, c.end_ - WORD_SIZE)
    if c.sender == SLAVE and c.end_ > 4 then
      add_open_bytes(c, c.tvb, WORD_SIZE, 4, "The first word of a good answer is not defined")
      add(c.tree, F.data, c.tvb, 4, c.end_ - 4)
      return
    end
    add_open_bytes(c, c.tvb, WORD_SIZE, c.end_, "Requests and lists of the short format 1 are not defined")
  end

  -- Code of the channel itself, in the first word of the data (FLP, page 11-15).
  local function add_channel_error(c)
    say(c, "error")
    if c.end_ < 4 then
      add_open_bytes(c, c.tvb, WORD_SIZE, c.end_)
      mark(c, nil, EX.synax_short, "Error code missing")
      return
    end
    local code = big_endian(c.bytes, WORD_SIZE)
    local text = range_text(code, N.channel_codes)

    if not text and rshift(code, 8) == SERIAL_ERRORS then text = strformat("Serial error %d", code % 0x100) end
    if not text then
      return add_open_bytes(c, c.tvb, WORD_SIZE, c.end_, "The place of the error code is not defined")
    end
    local item = add_value(c.tree, FX.synaxpk_code, c.tvb, WORD_SIZE, 2, code, "%s (0x%04x)", text, code)

    mark(c, item, EX.synax_error, "error 0x%04x: %s", code, text)
    c.words = c.words .. strformat(" 0x%04x: %s", code, text)
    add_open_bytes(c, c.tvb, 4, c.end_, "What follows the error code is not defined")
  end

  local sis_parts = {
    FX.synaxpk_sis_length, FX.synaxpk_sis_length_repeated, FX.synaxpk_sis_control, FX.synaxpk_sis_service,
  }

  local function add_sis_part(c, data)
    local length = data:len()
    local known = min(length, #sis_parts)

    for at = 0, known - 1 do
      local item = add(c.tree, sis_parts[at + 1], data, at, 1)

      if at == 3 then
        local name = S.service_name(data(at, 1):uint())

        append_text(item, " (" .. name .. ")")
        say(c, name)
      end
    end
    add_open_bytes(c, data, known, length, "Whether addresses stand before the data is not defined")
  end

  -- A telegram begins with its start character and has equal lengths; without that head it begins with the lengths.
  -- Returns the telegram for another dissector, if there is one.
  local function add_sis_data(c, data)
    local bytes = data:raw()
    local start, second, length, length_repeat = byte(bytes, 1, 4)

    if start == TELEGRAM_START and length_repeat and length == length_repeat then return data end
    if second and start == second then
      add_sis_part(c, data)
    else
      add_open_bytes(c, data, 0, #bytes, "Neither a telegram nor one without start character and sum")
    end
  end

  local function add_sis_format(c)
    local number = packet.number
    local length, is_last = c.end_ - WORD_SIZE, has(c, LAST_BIT)
    local piece = c.tvb(WORD_SIZE, length):tvb()
    local whole = piece

    kept_of[number] = kept_of[number] or {}
    local kept = kept_of[number]

    if not packet.visited then follow(c, kept) end
    say_bytes(c, length)
    if kept.is_repeated or kept.transfer or c.is_short then
      add(c.tree, FX.synaxpk_payload, c.tvb, WORD_SIZE, length)
    end
    if kept.is_repeated then
      say(c, "as before")
      return nil
    end
    if not is_last then say(c, "more follows") end
    if c.is_short then return nil end
    if kept.transfer then whole = S.put_next(c.tree, piece, kept.transfer, is_last) end
    return whole and add_sis_data(c, whole)
  end

  local function add_content(c)
    local format = band(c.word, 0xF)

    say(c, N.channel_formats[format] or "format not defined")
    if has(c, ERROR_BIT) and c.end_ == WORD_SIZE then
      say(c, "error bit")
      return nil
    end
    if format == SIS_FORMAT and has(c, ERROR_BIT) then
      add_channel_error(c)
      return nil
    end
    say(c, has(c, READ_BIT) and "channel read" or "channel write")
    if c.end_ == WORD_SIZE then
      say(c, "no data")
    elseif format == SIS_FORMAT then
      return add_sis_format(c)
    elseif format == DRIVE_SHORT_1 or format == A_SHORT_1 then
      add_short_1(c)
    else
      add_open_bytes(c, c.tvb, WORD_SIZE, c.end_, "This format is not defined")
    end
  end

  local function add_bits(c, which, parts)
    local item = add(c.tree, which, c.tvb, 0, 2)

    for _, part in ipairs(parts) do
      add(item, part, c.tvb, 0, 2)
    end
    return item
  end

  local word_bits = {
    FX.synaxpk_word_open, FX.synaxpk_word_error, FX.synaxpk_word_read, FX.synaxpk_word_busy, FX.synaxpk_word_last,
    FX.synaxpk_word_bit9, FX.synaxpk_word_toggle, FX.synaxpk_word_count, FX.synaxpk_word_format,
  }
  local drive_bits = {
    FX.synaxpk_drive_pf, FX.synaxpk_drive_error, FX.synaxpk_drive_last, FX.synaxpk_drive_toggle,
    FX.synaxpk_drive_fragment, FX.synaxpk_drive_length,
  }

  -- The word of SYNAX, and what follows it.
  local function add_synax(c)
    local item = add_bits(c, FX.synaxpk_word, word_bits)
    local telegram

    if has(c, OPEN_BITS) then mark(c, item, EX.synax_note, "Bits 14 and 15 are not defined") end
    c.end_ = WORD_SIZE
    if c.word == BASIC_STATE then
      say(c, "basic state")
    elseif has(c, ERROR_BIT) and c.sender == MASTER then
      say(c, "clear error")
    else
      read_extent(c)
      telegram = add_content(c)
    end
    add_bytes(c.tree, FX.synaxpk_beyond, c.tvb, c.end_, c.there)
    return telegram
  end

  -- Index 0x2000 and above: an S parameter; the subindex is its element (IndraDrive MPH-02, page 4-48).
  local function add_index(c)
    local index, element = big_endian(c.bytes, WORD_SIZE), big_endian(c.bytes, 4)

    add(c.tree, FX.synaxpk_index, c.tvb, WORD_SIZE, 2)
    add(c.tree, FX.synaxpk_subindex, c.tvb, 4, 2)
    say(c, strformat("index 0x%04x, subindex %d", index, element))
    if index < FIRST_S_INDEX or index >= S_INDEX_END then return end
    local ident = S.ident(0, index - FIRST_S_INDEX)

    if c.tree then S.add_ident(c.tree, c.tvb, {offset = 0, length = 0}, ident, S.known_from_tables(ident)) end
    c.words = c.words .. " (" .. ident.text .. ")"
  end

  -- An order begins with index and subindex; idents of 4 bytes extend them (HDx-19, page 94). Returns where its data
  -- begin.
  local function add_order(c)
    if has(c, DRIVE_PF_BIT) then
      mark(c, nil, EX.synax_note, "Orders with an ident of 4 bytes are not decoded")
      return WORD_SIZE
    end
    add_index(c)
    return ORDER_HEAD_END
  end

  -- IndraDrive: fragments are not reassembled.
  local function add_indradrive(c)
    local fragment, there, at = band(rshift(c.word, 8), 0xF), c.there - WORD_SIZE, WORD_SIZE
    local is_alone = has(c, DRIVE_LAST_BIT) and fragment == band(c.word, 0xFF)

    add_bits(c, FX.synaxpk_drive, drive_bits)
    if fragment > there then mark(c, nil, EX.synax_short, "The data are cut") end
    c.end_ = WORD_SIZE + min(fragment, there)
    if c.sender == SLAVE and has(c, DRIVE_ERROR_BIT) then
      say(c, "error")
      mark(c, nil, EX.synax_error, "The drive reports an error")
    end
    say_bytes(c, c.end_ - WORD_SIZE)
    if c.sender == MASTER and is_alone and c.end_ >= ORDER_HEAD_END then at = add_order(c) end
    add_bytes(c.tree, FX.synaxpk_payload, c.tvb, at, c.end_)
    add_bytes(c.tree, FX.synaxpk_beyond, c.tvb, c.end_, c.there)
  end

  local function check_size(c)
    if c.all == c.there then return end
    add_bytes(c.tree, F.raw, c.tvb, c.there, #c.bytes)
    mark(c, nil, EX.synax_unexpected, "Bytes after the six words of the channel")
  end

  -- Of a channel that the capture has cut, nothing is certain.
  local function add_cut(c, is_synax)
    add_sender(c)
    say(c, "Cut channel")
    add_bytes(c.tree, F.raw, c.tvb, 0, #c.bytes)
    if not packet.visited and is_synax then forget(c) end
  end

  -- Everything but the telegram for another dissector.
  local function add_channel(c)
    local is_synax, telegram = synaxpk.prefs.layout == SYNAX, nil

    c.there = is_synax and min(c.all, CHANNEL_SIZE) or c.all
    if c.there > #c.bytes then return add_cut(c, is_synax) end
    if c.there < WORD_SIZE then
      add_open_bytes(c, c.tvb, 0, c.there)
      mark(c, nil, EX.synax_short, "The control or status word is cut")
      say(c, "Cut channel")
      return nil
    end
    c.word = big_endian(c.bytes, 0)
    add_sender(c)
    if is_synax then telegram = add_synax(c) else add_indradrive(c) end
    check_size(c)
    if not packet.visited and is_synax then follow_word(c) end
    return telegram
  end

  function synaxpk.dissector(tvb, pinfo, parent)
    S.begin_packet(pinfo)
    local tree, cols = parent:add(synaxpk, tvb()), pinfo.cols
    local c = {tvb = tvb, bytes = tvb:raw(), all = tvb:reported_len(), pinfo = pinfo, tree = tree, root = tree,
      words = ""}

    cols.protocol = "SYNAXPK"
    cols.info = ""
    local telegram = add_channel(c)
    cols.info = c.words
    append_text(tree, ", " .. c.words)
    if telegram then
      cols.info:append(" | ")
      cols.info:fence()
      Dissector.get("sis"):call(telegram, pinfo, parent)
    end
    if #c.bytes < c.all then S.show_cut(tvb, pinfo, parent, "SYNAXPK") end
  end
end

--- synax/synaxobj: objects of SYNAX200 (chapter 2). 5E70 to 5E73 hold a SIS telegram: a request is written, its answer
-- is read from the same object (p. 2-16). 5FF0 to 5FF6 are diagnosis words (p. 2-36 to 2-40).

do
  local WORD_SIZE = 2
  local READ_ANSWER, WRITE_REQUEST = K.SYNAXOBJ_READ_ANSWER, K.SYNAXOBJ_WRITE_REQUEST
  local DIAGNOSIS_FIELDBUS, STATUS_FIELDBUS = K.SYNAXOBJ_DIAGNOSIS_FIELDBUS, K.SYNAXOBJ_STATUS_FIELDBUS
  local FAULT_CODE_PPC = K.SYNAXOBJ_FAULT_CODE_PPC
  local NO_BUS_FAILURE = K.SYNAXOBJ_STATUS_BUS

  -- For each index: size in bytes; for a word its field, the fields in it, and its undefined bits.
  local objects = {
    [0x5E70] = {size = 16, of_telegrams = true},
    [0x5E71] = {size = 32, of_telegrams = true},
    [0x5E72] = {size = 64, of_telegrams = true},
    [0x5E73] = {size = 128, of_telegrams = true},
    [DIAGNOSIS_FIELDBUS] = {size = WORD_SIZE, field = FX.synaxobj_diagnosis, open_bits = 0xFF00,
      fields = {FX.synaxobj_diagnosis_interface, FX.synaxobj_diagnosis_fault}},
    [STATUS_FIELDBUS] = {size = WORD_SIZE, field = FX.synaxobj_status, open_bits = 0xFFF7,
      fields = {FX.synaxobj_status_bus, FX.synaxobj_status_memory}},
    [0x5FF5] = {size = WORD_SIZE, field = FX.synaxobj_ppc, fields = {}, open_bits = 0xFFFF},
    [FAULT_CODE_PPC] = {size = WORD_SIZE, field = FX.synaxobj_fault, open_bits = 0xFFFF,
      fields = {FX.synaxobj_fault_communication, FX.synaxobj_fault_process_data}},
    [0x5FFC] = {},
    [0x5FFD] = {},
    [0x5FFE] = {},
  }

  function S.is_object_known(index)
    return objects[index] ~= nil
  end

  local requests, links -- the last write request of each object; relations of a packet

  at_init(function() requests, links = {}, {} end)

  -- One exchange is a write request and one or more reads of the same object (p. 2-16). Found in the first pass, and
  -- kept for later passes.
  local function find_link(place, access)
    local number = packet.number
    local known, object = links[number] and links[number][place], objects[access.index]

    if known or packet.visited or not object.of_telegrams then return known end
    local key = S.line_key(S.place()) .. " " .. access.channel .. " " .. access.index
    local before = requests[key]

    known = S.asked_new({end_ = packet.time})
    if access.operation == WRITE_REQUEST then
      if before then before.next_in = number end
      requests[key] = known
    elseif access.operation == READ_ANSWER and before then
      S.asked_answer(known, before, {begin = packet.time})
    end
    links[number] = links[number] or {}
    links[number][place] = known
    return known
  end

  local function show_link(d, link)
    if not link then return end
    S.asked_show(link, d.tree, d.tvb, "synax_request_in", "synax_answer_in", "synax_answer_time")
    if link.next_in and not link.answer_in then
      add_generated(d.tree, FX.synax_next_request_in, d.tvb, link.next_in)
      add_expert(d.root, EX.synax_unanswered, "No answer was read before the next write request")
    end
  end

  local function dissect_no_telegram(d)
    local is_empty = not string.find(d.bytes, "[^%z]")

    add_bytes(d.tree, FX.synaxobj_raw, d.tvb, d.offset, d.offset + d.length)
    d.pinfo.cols.info:append(is_empty and "  empty" or "  no telegram")
    if not is_empty then add_expert(d.root, EX.synax_note, "The object does not begin with a telegram") end
  end

  -- The whole telegram with its head of 8 bytes, and the padding of the object (p. 2-16).
  local function dissect_telegram(d)
    local declared = S.declared_length(d.bytes, 0)
    local extent = declared > 0 and declared <= d.length and declared or d.length
    local info = d.pinfo.cols.info

    if byte(d.bytes, 1) ~= K.START then return dissect_no_telegram(d) end
    add_bytes(d.tree, FX.synaxobj_padding, d.tvb, d.offset + extent, d.offset + d.length)
    info:append("  ")
    info:fence()
    Dissector.get("sis"):call(d.tvb(d.offset, extent):tvb(), d.pinfo, d.parent)
  end

  -- Each undefined set bit by its number, and one note for all of them.
  local function add_open_bits(d, item, bits)
    local numbers = {}

    for number = 0, 15 do
      if band(rshift(bits, number), 1) ~= 0 then
        add(item, FX.synaxobj_open_bit, d.tvb, d.offset, WORD_SIZE, number)
        numbers[#numbers + 1] = number
      end
    end
    if bits ~= 0 then
      add_expert(item or d.root, EX.synax_note, "What these bits mean is not defined: " .. concat(numbers, ", "))
    end
  end

  local function report_fault(d, item, word)
    local low, index = band(word, 0xFF), d.access.index

    if index == FAULT_CODE_PPC and word ~= 0 then
      add_expert(item or d.root, EX.synax_error,
        strformat("Fault of the PPC: process data channel 0x%02x, communication channel 0x%02x", low,
          rshift(word, 8)))
    elseif index == DIAGNOSIS_FIELDBUS and low ~= 0 then
      add_expert(item or d.root, EX.synax_error, strformat("Fault of the fieldbus: 0x%02x", low))
    elseif index == STATUS_FIELDBUS and band(word, NO_BUS_FAILURE) == 0 then
      add_expert(item or d.root, EX.synax_failed)
    end
  end

  -- High byte first, as PCP has its words.
  local function dissect_word(d, object)
    local high, low = byte(d.bytes, 1, 2)

    if d.length < WORD_SIZE then
      add_bytes(d.tree, FX.synaxobj_raw, d.tvb, d.offset, d.offset + d.length)
      add_expert(d.root, EX.synax_short, "The object has 2 bytes, not 1")
      return
    end
    local word = high * 0x100 + low
    local item = add(d.tree, object.field, d.tvb, d.offset, WORD_SIZE)

    for _, which in ipairs(object.fields) do
      add(item, which, d.tvb, d.offset, WORD_SIZE)
    end
    add_open_bits(d, item, band(word, object.open_bits))
    report_fault(d, item, word)
    add_bytes(d.tree, FX.synaxobj_raw, d.tvb, d.offset + WORD_SIZE, d.offset + d.length)
    d.pinfo.cols.info:append(strformat("  0x%04x", word))
  end

  local function dissect_unknown(d)
    add_bytes(d.tree, FX.synaxobj_raw, d.tvb, d.offset, d.offset + d.length)
    d.pinfo.cols.info:append(strformat("  %d byte%s", d.length, plural(d.length)))
    add_expert(d.root, EX.synax_note, "Control or status word of the multiplex channel: which bits are Index_out_c, "
      .. "Index_in_c, RR and RA is not defined")
  end

  -- A write request and a read answer contain the object, the others do not.
  local function dissect_content(d)
    local object, operation = objects[d.access.index], d.access.operation

    if operation ~= WRITE_REQUEST and operation ~= READ_ANSWER then return end
    if object.size and d.length > object.size then
      add_expert(d.root, EX.synax_unexpected, "More bytes than the object has")
    end
    if d.length == 0 then
      add_expert(d.root, EX.synax_short, "The content of the object is missing")
    elseif not object.size then
      dissect_unknown(d)
    elseif object.of_telegrams then
      dissect_telegram(d)
    else
      dissect_word(d, object)
    end
  end

  -- An object on another bus: `length` available bytes at `offset`. Appends to the info column. `access` has index,
  -- operation, and channel, which distinguishes the devices of a bus.
  function S.dissect_object(tvb, offset, length, pinfo, parent, access)
    local root = parent:add(synaxobj, tvb(offset, length))
    local d = {tvb = tvb, pinfo = pinfo, parent = parent, tree = root, root = root, offset = offset, length = length,
      access = access, bytes = length > 0 and tvb(offset, length):bytes():raw() or ""}

    pinfo.cols.protocol = "SYNAXOBJ"
    add_generated(root, FX.synaxobj_index, tvb, access.index)
    add_generated(root, FX.synaxobj_operation, tvb, access.operation)
    append_text(root, strformat(", 0x%04X %s", access.index, N.synaxobj_operations[access.operation]))
    pinfo.cols.info:append(strformat("  0x%04X", access.index))
    show_link(d, find_link(tvb:offset() + offset, access))
    dissect_content(d)
  end
end

--- synax/synaxpcp: Interbus PCP: service code, word count, invoke id, communication reference, and what the service
-- brings. All words have the high byte first.

do
  local HEAD_SIZE, REFERENCE_END, RESULT_END = 4, 6, 8
  local SUBINDEX_AT, LENGTH_AT, DATA_AT = 8, 9, 10

  -- Bits of the codes 0081, 0082, 00A1 ... 01A2. SECOND: a confirmation or an indication: what the other has begun
  -- arrives.
  local OF_DEVICE, SECOND = 0x0020, 0x0100

  -- A service on an object; nil: it is another service. The master sees request and confirmation, the device
  -- indication and response.
  local function read_access(code)
    local service, is_at_device = band(code, 0xFFFF - OF_DEVICE - SECOND), band(code, OF_DEVICE) ~= 0

    if service ~= 0x0081 and service ~= 0x0082 then return nil end
    return {is_write = service == 0x0082, is_at_device = is_at_device,
      is_answer = is_at_device ~= (band(code, SECOND) ~= 0)}
  end

  local requests, links -- the last request of each kind; relations of a packet

  at_init(function() requests, links = {}, {} end)

  local function word_at(d, offset)
    return byte(d.bytes, offset + 1) * 0x100 + byte(d.bytes, offset + 2)
  end

  local function key_of(d, is_at_device)
    return concat({S.line_key(S.place()), word_at(d, HEAD_SIZE), tostring(d.access.is_write), tostring(is_at_device)},
      " ")
  end

  -- A request names its object.
  local function begin_exchange(d, link)
    link.request, link.index, link.subindex = link, word_at(d, REFERENCE_END), byte(d.bytes, SUBINDEX_AT + 1)
    requests[key_of(d, d.access.is_at_device)] = link
  end

  -- At the same end of the bus, else at the other: a log may have only requests and responses.
  local function end_exchange(d, link)
    for _, place in ipairs({d.access.is_at_device, not d.access.is_at_device}) do
      local request = requests[key_of(d, place)]

      if request and not request.answer_in then
        link.request = request
        S.asked_answer(link, request, {begin = packet.time})
        return
      end
    end
  end

  -- Found in the first pass, and kept for every later one.
  local function find_link(d)
    local number, place = packet.number, d.tvb:offset()
    local known = links[number] and links[number][place]

    if known or packet.visited then return known or {} end
    known = S.asked_new({end_ = packet.time})
    if d.access.is_answer then end_exchange(d, known) else begin_exchange(d, known) end
    links[number] = links[number] or {}
    links[number][place] = known
    return known
  end

  local function show_link(d, link)
    S.asked_show(link, d.tree, d.tvb, "synaxpcp_request_in", "synaxpcp_response_in", "synaxpcp_response_time")
  end

  local function say_short(d, needed)
    add_expert(d.root, EX.synax_short, strformat("The message has at least %d bytes", needed))
  end

  local function note_data(item, request)
    if not request then
      add_expert(item, EX.synax_note, "The request is not in the capture: the object is not known")
    elseif S.is_object_known(request.index) then
      add_expert(item, EX.synax_note,
        strformat("What element %d of the object holds is not defined", request.subindex))
    else
      add_expert(item, EX.synax_note, strformat("What object 0x%04X holds is not defined", request.index))
    end
  end

  -- Passes on objects of SYNAX, complete: an element of an object may be anything.
  local function dissect_data(d, length, request)
    local operation = (d.access.is_answer and (d.access.is_write and 3 or 0)) or (d.access.is_write and 1 or 2)
    local info = d.pinfo.cols.info

    if request and request.subindex == 0 and S.is_object_known(request.index) then
      S.dissect_object(d.tvb, length > 0 and DATA_AT or d.end_, length, d.pinfo, d.parent,
        {index = request.index, operation = operation, channel = byte(d.bytes, HEAD_SIZE + 2)})
      return
    end
    if request then info:append(strformat("  0x%04X.%d", request.index, request.subindex)) end
    if length == 0 then return end
    local item = add(d.tree, FX.synaxpcp_data, d.tvb, DATA_AT, length)

    info:append(strformat(", %d byte%s", length, plural(length)))
    note_data(item, request)
  end

  -- The length, the data, and the byte that pads a word.
  local function dissect_length(d, request)
    local length, there = byte(d.bytes, LENGTH_AT + 1), d.end_ - DATA_AT
    local item = add(d.tree, FX.synaxpcp_length, d.tvb, LENGTH_AT, 1)

    if length > there then
      add_expert(item, EX.synax_short, "The data are cut")
    else
      add_bytes(d.tree, FX.synaxpcp_padding, d.tvb, DATA_AT + length, d.end_)
    end
    dissect_data(d, min(length, there), request)
  end

  -- Read and write request, and their indications.
  local function dissect_request(d)
    local needed = d.access.is_write and DATA_AT or SUBINDEX_AT + 1

    if d.end_ < needed then
      add_bytes(d.tree, FX.synaxpcp_raw, d.tvb, REFERENCE_END, d.end_)
      say_short(d, needed)
      return
    end
    add(d.tree, FX.synaxpcp_index, d.tvb, REFERENCE_END, 2)
    add(d.tree, FX.synaxpcp_subindex, d.tvb, SUBINDEX_AT, 1)
    local link = find_link(d)

    show_link(d, link)
    if d.access.is_write then return dissect_length(d, link.request) end
    add_bytes(d.tree, FX.synaxpcp_padding, d.tvb, SUBINDEX_AT + 1, d.end_)
    dissect_data(d, 0, link.request)
  end

  -- Error class, error code and additional code instead of a result.
  local function dissect_error(d)
    local class, code = byte(d.bytes, REFERENCE_END + 1, REFERENCE_END + 2)
    local additional = word_at(d, RESULT_END)
    local item = add(d.tree, FX.synaxpcp_error, d.tvb, REFERENCE_END, 4)
    local text = N.synaxpcp_errors[(class * 0x100 + code) * 0x10000 + additional]
    local words = strformat("Error class %d, code %d, additional 0x%04x", class, code, additional)
      .. (text and ", at ABB: " .. text or "")

    add(item, FX.synaxpcp_error_class, d.tvb, REFERENCE_END, 1)
    add(item, FX.synaxpcp_error_code, d.tvb, REFERENCE_END + 1, 1)
    add(item, FX.synaxpcp_error_additional, d.tvb, RESULT_END, 2)
    add_expert(item, EX.synax_error, words)
    d.pinfo.cols.info:append("  " .. words)
    add_bytes(d.tree, FX.synaxpcp_raw, d.tvb, RESULT_END + 2, d.end_)
  end

  -- Result 0, and the data read.
  local function dissect_result(d, request)
    add(d.tree, FX.synaxpcp_result, d.tvb, REFERENCE_END, 2)
    if d.access.is_write then
      add_bytes(d.tree, FX.synaxpcp_raw, d.tvb, RESULT_END, d.end_)
      dissect_data(d, 0, request)
    elseif d.end_ < DATA_AT then
      add_bytes(d.tree, FX.synaxpcp_raw, d.tvb, RESULT_END, d.end_)
      say_short(d, DATA_AT)
    else
      add(d.tree, FX.synaxpcp_padding, d.tvb, RESULT_END, 1)
      dissect_length(d, request)
    end
  end

  -- Response and confirmation: they do not name the object.
  local function dissect_answer(d)
    local link = find_link(d)
    local request = link.request

    show_link(d, link)
    add_generated(d.tree, FX.synaxpcp_index_of_request, d.tvb, request and request.index)
    if d.end_ >= RESULT_END and word_at(d, REFERENCE_END) == 0 then
      dissect_result(d, request)
    elseif d.end_ >= RESULT_END + 2 then
      dissect_error(d)
    else
      add_bytes(d.tree, FX.synaxpcp_raw, d.tvb, REFERENCE_END, d.end_)
      say_short(d, d.end_ < RESULT_END and RESULT_END or RESULT_END + 2)
    end
  end

  local function dissect_other(d, code)
    add_bytes(d.tree, FX.synaxpcp_raw, d.tvb, REFERENCE_END, d.end_)
    if not N.synaxpcp_services[code] then
      add_expert(d.root, EX.synax_note, strformat("Service code 0x%04x is not defined%s", code, rshift(code, 8) == 0x80
        and ": older controllers have such codes, and manuals differ in which is a request" or ""))
    elseif REFERENCE_END < d.end_ then
      add_expert(d.root, EX.synax_note, "What this service brings is not decoded")
    end
  end

  local function dissect_message(d)
    local code = word_at(d, 0)
    local name = N.synaxpcp_services[code] or strformat("Service 0x%04x", code)

    d.access = read_access(code)
    append_text(d.root, ", " .. name)
    d.pinfo.cols.info:append(name)
    if d.end_ < REFERENCE_END then
      add_bytes(d.tree, FX.synaxpcp_raw, d.tvb, HEAD_SIZE, d.end_)
      say_short(d, REFERENCE_END)
      return
    end
    add(d.tree, FX.synaxpcp_invoke, d.tvb, HEAD_SIZE, 1)
    add(d.tree, FX.synaxpcp_reference, d.tvb, HEAD_SIZE + 1, 1)
    if not d.access then
      dissect_other(d, code)
    elseif d.access.is_answer then
      dissect_answer(d)
    else
      dissect_request(d)
    end
  end

  -- Service code and word count; decodes the words that are counted.
  local function dissect_head(d)
    local there, count = #d.bytes, word_at(d, 2)
    local finish = HEAD_SIZE + 2 * count

    add(d.tree, FX.synaxpcp_service, d.tvb, 0, 2)
    local item = add(d.tree, FX.synaxpcp_count, d.tvb, 2, 2)

    d.end_ = min(finish, there)
    if finish > there then
      add_expert(item, EX.synax_short, "Fewer words than counted")
    elseif finish < there then
      add_expert(item, EX.synax_unexpected, "Bytes after the last word")
      add(d.tree, FX.synaxpcp_raw, d.tvb, finish, there - finish)
    end
    dissect_message(d)
  end

  -- Less than a head, or cut by the capture: then a length is meaningless.
  local function dissect_stump(d, is_cut)
    d.pinfo.cols.info:append("Cut message")
    add_bytes(d.tree, FX.synaxpcp_raw, d.tvb, 0, #d.bytes)
    if not is_cut then
      add_expert(d.root, EX.synax_short, "Service code and word count have 4 bytes")
    end
  end

  function synaxpcp.dissector(tvb, pinfo, parent)
    local bytes = tvb:raw()
    local is_cut = #bytes < tvb:reported_len()
    local tree = parent:add(synaxpcp, tvb(0, #bytes))
    local d = {tvb = tvb, bytes = bytes, pinfo = pinfo, parent = parent, tree = tree, root = tree}

    look_at(pinfo)
    pinfo.cols.protocol = "SYNAXPCP"
    pinfo.cols.info:clear()
    if #bytes < HEAD_SIZE or is_cut then dissect_stump(d, is_cut) else dissect_head(d) end
    if is_cut then S.show_cut(tvb, pinfo, parent, "SYNAXPCP") end
    return #bytes
  end
end

--- synax/synaxpd: process data over UDP (chapter 6, card ETH01): the payload is the data, without any head. What its
-- words are stands in parameters of the PPC only; the user's table of the plugin cannot be here.

do
  local WORDS_SHOWN = 8 -- in the packet list
  local PORT_TYPE_UDP = 3
  local SENT, RECEIVED = 0, 1 -- of pinfo.p2p_dir
  local TO_PPC, FROM_PPC = K.SYNAXPD_TO_PPC, K.SYNAXPD_FROM_PPC

  local taken = "" -- ranges of ports, as text

  local function is_taken(port)
    for first, last in string.gmatch(taken, "(%d+)%-?(%d*)") do
      if port >= tonumber(first) and port <= (tonumber(last) or tonumber(first)) then return true end
    end
    return false
  end

  -- The preference selects the port of the PPC; a packet without ports may have a direction of its own.
  local function find_direction(pinfo)
    if pinfo.port_type ~= PORT_TYPE_UDP then
      return pinfo.p2p_dir == SENT and TO_PPC or pinfo.p2p_dir == RECEIVED and FROM_PPC or nil
    end
    local is_to, is_from = is_taken(pinfo.dst_port), is_taken(pinfo.src_port)

    if is_to == is_from then return nil end
    return is_to and TO_PPC or FROM_PPC
  end

  -- High byte first, unless C-0-0129 says otherwise (p. 6-4).
  local function word_at(bytes, word)
    local one, two = byte(bytes, 2 * word + 1, 2 * word + 2)

    if synaxpd.prefs.swap_bytes then return two * 0x100 + one end
    return one * 0x100 + two
  end

  local function add_word(tree, tvb, bytes, word)
    local value = word_at(bytes, word)

    add(tree, FX.synaxpd_word, tvb, 2 * word, 2, value, strformat("Word %d: 0x%04x (%d)", word + 1, value, value))
  end

  local function info_text(bytes, count, direction)
    local words = {}

    for word = 0, min(count, WORDS_SHOWN) - 1 do
      words[word + 1] = strformat("%04x", word_at(bytes, word))
    end
    return strformat("Process data%s, %d word%s%s%s%s", direction and " " .. N.synaxpd_directions[direction] or "",
      count, plural(count), count > 0 and ": " or "", concat(words, " "), count > WORDS_SHOWN and " ..." or "")
  end

  function synaxpd.dissector(tvb, pinfo, parent)
    local bytes, is_cut = tvb:raw(), tvb:len() < tvb:reported_len()
    local there, count, direction = #bytes, floor(#bytes / 2), find_direction(pinfo)
    local tree = parent:add(synaxpd, tvb(0, there))

    pinfo.cols.protocol = "SYNAXPD"
    add_generated(tree, FX.synaxpd_direction, tvb, direction)
    for word = 0, count - 1 do
      add_word(tree, tvb, bytes, word)
    end
    if there % 2 == 1 then
      add(tree, FX.synaxpd_raw, tvb, there - 1, 1)
      if not is_cut then add_expert(tree, EX.synax_unexpected, "Half a word at the end") end
    end
    pinfo.cols.info = info_text(bytes, count, direction)
    if is_cut then S.show_cut(tvb, pinfo, parent, "SYNAXPD") end
    return there
  end

  -- For each file, and not when preferences are applied.
  at_init(function()
    local ports, udp = synaxpd.prefs.ports, DissectorTable.get("udp.port")

    if taken ~= "" then udp:remove(taken, synaxpd) end
    if ports ~= "" then udp:add(ports, synaxpd) end
    taken = ports
  end)

  DissectorTable.get("udp.port"):add_for_decode_as(synaxpd)
end

--- sis/segments: the characters of a serial line that come over TCP. A terminal server may speak Telnet (RFC 854; RFC
-- 2217 sets the line's rate by it): it begins with a negotiation. From then on each FF is doubled, and commands stand
-- anywhere between the characters.

do
  local IAC, SB, WILL, DO = 0xFF, 0xFA, 0xFB, 0xFD
  local COMMAND_END = "\255\240" -- IAC SE
  local COM_PORT = 0x2C -- the option of RFC 2217; what else serial lines need has smaller numbers
  local NEGOTIATION_LENGTH = 3 -- that shows what it is; fewer bytes may become one
  local find = string.find

  local telnet_from -- for each connection: the packet from which on it is Telnet

  at_init(function() telnet_from = {} end)

  -- Of the command at offset; more than there is: its end is missing. 0: a character, FF FF included.
  local function command_length(bytes, offset)
    local there = #bytes - offset
    local first, verb = byte(bytes, offset + 1, offset + 2)

    if first ~= IAC then return 0 end
    if there == 1 then return 2 end
    if verb == IAC then return 0 end
    if verb ~= SB then return verb > SB and 3 or 2 end
    local _, last = find(sub(bytes, offset + 1, offset + K.MOST_TELNET), COMMAND_END, 3, true)

    return last or (there < K.MOST_TELNET and there + 1 or 2)
  end

  -- Noise of a line begins so in one segment of 180,000.
  local function is_negotiation(bytes)
    local first, verb, option = byte(bytes, 1, NEGOTIATION_LENGTH)

    if first ~= IAC or not option then return false end
    return verb == SB and option == COM_PORT or (verb == WILL or verb == DO) and option <= COM_PORT
  end

  -- Notes whether a segment begins with a negotiation of Telnet. Also for one that nobody dissects yet.
  function S.segments_look(bytes, pinfo)
    if not is_negotiation(bytes) then return end
    local connection = S.connection(pinfo)

    telnet_from[connection] = telnet_from[connection] or pinfo.number
  end

  -- What is left of a segment; where each character stands in it, from 0, then what is no character yet; the end of
  -- what is whole.
  local function characters_of(bytes)
    local values, places, at = {}, {}, 0

    while at < #bytes do
      local length = command_length(bytes, at)

      if length > #bytes - at then break end
      if length == 0 then
        places[#values], values[#values + 1] = at, sub(bytes, at + 1, at + 1)
        length = byte(bytes, at + 1) == IAC and 2 or 1
      end
      at = at + length
    end
    places[#values] = at
    return concat(values), places, at
  end

  -- Returns whether the units, one of which may say itself that it is cut, end where the segment did before the capture
  -- has cut that many bytes. If not, TCP throws an error without a message. It takes a unit that is longer than a tvb
  -- for one that goes on in the next segment.
  local function dissect_units(tvb, tree, length_of, dissect_unit, cut)
    if not tvb then return cut == 0 end
    local bytes, most = tvb:raw(), cut > 0 and tvb:reported_len() or math.huge
    local there, length, last = #bytes + cut, 0, 0
    local _, message = pcall(dissect_tcp_pdus, tvb, tree, 1, function(_, pinfo, offset)
      length = length_of(bytes, pinfo, offset, there)
      last = offset + length
      return min(length, most - offset)
    end, function(unit, pinfo, parent) return dissect_unit(unit, pinfo, parent, length) end)

    if message then error(message, 0) end
    return cut == 0 or last >= there
  end

  local function wait_for_more(pinfo, offset)
    pinfo.desegment_offset, pinfo.desegment_len = offset, DESEGMENT_ONE_MORE_SEGMENT
  end

  -- Dissects each unit. length_of() says how long the one at an offset is, or 0 if more bytes are needed. It gets the
  -- bytes, and how many there were before the capture cut them; dissect_unit() gets the length.
  function S.segments_dissect(tvb, pinfo, tree, length_of, dissect_unit, name)
    local bytes = tvb:raw()
    local characters, places, last = tvb, nil, #bytes

    S.segments_look(bytes, pinfo)
    local from = telnet_from[S.connection(pinfo)]

    if from and from <= pinfo.number then
      local left

      left, places, last = characters_of(bytes)
      characters = left ~= "" and ByteArray.new(left, true):tvb("Characters without Telnet") or nil
    elseif pinfo.can_desegment > 0 and #bytes < NEGOTIATION_LENGTH and command_length(bytes, 0) > #bytes then
      last = 0
    end
    if last > 0 and not dissect_units(characters, tree, length_of, dissect_unit, tvb:reported_len() - #bytes) then
      S.show_cut(tvb, pinfo, tree, name)
    end
    if pinfo.desegment_len > 0 and places then
      wait_for_more(pinfo, places[pinfo.desegment_offset]) -- nobody knows how many bytes that takes
    elseif pinfo.desegment_len == 0 and pinfo.can_desegment > 0 and last < #bytes then
      wait_for_more(pinfo, last)
    end
  end

  local recognized_in -- for each connection: the first packet of ours

  at_init(function() recognized_in = {} end)

  -- Gives a connection to a dissector from this packet on. `dissect` is that of the protocol: called by it, it could
  -- not ask TCP for more.
  function S.recognize(tvb, pinfo, tree, proto, dissect)
    local connection = S.connection(pinfo)

    recognized_in[connection] = recognized_in[connection] or pinfo.number
    pinfo.conversation = proto
    dissect(tvb, pinfo, tree)
    return true
  end

  -- Everything before was something else, in the second pass, too.
  function S.is_before(pinfo)
    local first = recognized_in[S.connection(pinfo)]

    return first and pinfo.number < first
  end

  -- The info column may have text: of another unit of this packet, or of TCP, which ends with a space.
  function S.separator(info)
    local last = sub(tostring(info), -1)

    return (last == "" or last == " ") and "" or " | "
  end
end

--- ascii/dialogue: command, echo and answer of the ASCII protocol. A drive echoes each line but the one that opens it.
-- Its answer ends with its prompt, or with "?" while it waits for an element of a list (MPH-02, p. 10-86 to 10-91).
-- Between a command and its answer, the same line once more is its echo; a shared line does not show who sent it.

do
  local TEXT, OPEN, PROMPT, READ = K.SISASCII_TEXT, K.SISASCII_OPEN, K.SISASCII_PROMPT, K.SISASCII_READ
  local WRITE, ELEMENT, ASKS, ERROR = K.SISASCII_WRITE, K.SISASCII_ELEMENT, K.SISASCII_ASKS, K.SISASCII_ERROR
  local ECHO, ANSWER, END = K.SISASCII_ECHO, K.SISASCII_ANSWER, K.SISASCII_END

  -- Of both directions of a tap, or of a TCP connection: {command: the last one, list: the write whose elements are
  -- expected, is_asked: for the next of them, is_mute: what seemed to be an echo was a repeat: nobody echoes now,
  -- drive: that is open}. A command: {said, list, body: for what is known of its parameter, values, asked: its line,
  -- end_in, next_in, unanswered_before, repeat_of, error, is_echoed, drive}. A unit: what it asks, or answers if it is
  -- the first line of an answer, and {kind, command, is_command, index, drive, limit}.
  local buses, units

  at_init(function() buses, units = {}, {} end)

  local function is_waiting(command) return command ~= nil and not command.asked.answer_in end

  -- Whether the last command may have this line as an answer.
  local function can_answer(n)
    local command = n.bus.command

    return command and not command.end_in and S.may_answer(n.unit, command.asked)
  end

  local function is_same(n, command) return command and n.said.text == command.said.text end

  local function is_echo(n)
    local command = n.bus.command

    return can_answer(n) and is_waiting(command) and is_same(n, command) and not command.is_echoed
      and (n.unit.line ~= 0 or not n.bus.is_mute and command.kind ~= OPEN)
  end

  -- Characters that were lost or damaged since may have been the answer.
  local function is_disturbed(since)
    local seen = packet.record and packet.record.known

    return seen and (seen.lost_in > since or seen.unframed_in > since)
  end

  -- The next command comes: was the one before answered?
  local function follow(n, command)
    local before = n.bus.command

    if not is_waiting(before) then return end
    if before.is_echoed then n.bus.is_mute = true end
    if is_same(n, before) then command.repeat_of = before.repeat_of or before.asked.frame end
    if is_disturbed(before.asked.frame) then return end
    before.next_in, command.unanswered_before = command.asked.frame, before.asked.frame
  end

  local function begin(n, kind)
    local command = {said = n.said, kind = kind, values = {}, asked = n.unit}

    n.unit.kind, n.unit.command, n.unit.is_command = kind, command, true
    follow(n, command)
    command.drive = n.bus.drive
    n.bus.command, n.bus.is_asked = command, false
    return command
  end

  local function keep_value(command, text)
    command.values[#command.values + 1] = text
  end

  -- What the bus has said of a parameter is looked up like that of a telegram: the address of a drive is that of its
  -- only device, too (MPH-02, p. 10-100).
  local function look_up(n, command)
    if not command.drive then return end
    command.body = {request = {},
      record = {exchange = {from = {path = char(command.drive), stream = {bus = n.sis_bus}}}}}
    S.learned_known(command.body, command.said.ident, command.drive)
    command.body.asked = command.body.request
  end

  local function begin_access(n)
    local said = n.said
    local command = begin(n, said.kind)

    n.bus.list = nil
    look_up(n, command)
    if said.kind ~= WRITE then return end
    if said.value == ">" then n.bus.list = command else keep_value(command, said.value) end
  end

  -- What follows "?": an element, or "<" after the last one.
  local function begin_element(n)
    local command = begin(n, n.said.text == "<" and END or ELEMENT)

    command.list = n.bus.list
    if command.kind == END then return end
    keep_value(command.list, n.said.text)
    n.unit.index = #command.list.values
  end

  local function answer(n, kind)
    local command = n.bus.command

    n.unit.kind, n.unit.command = kind, command
    n.bus.is_mute = false
    if is_waiting(command) then S.asked_answer(n.unit, command.asked, n.times) end
  end

  local learnt = {[K.ELEMENT_NAME] = "name", [K.ELEMENT_UNIT] = "unit", [K.ELEMENT_MINIMUM] = "minimum",
    [K.ELEMENT_MAXIMUM] = "maximum"} -- an attribute as text is not documented

  local function note_value(n)
    local command = n.bus.command

    answer(n, ANSWER)
    if command.kind ~= READ then return end
    local what = learnt[command.said.element]

    if #command.values == 0 and what and command.drive then
      S.learned_add(n.sis_bus, char(command.drive), command.said.ident, command.drive, what, n.said.text)
    end
    keep_value(command, n.said.text)
    if #command.values > 1 then n.unit.index = #command.values end
  end

  local notes = {
    [OPEN] = function(n)
      n.bus.drive, n.bus.list = n.said.drive, nil
      begin(n, OPEN)
    end,
    [READ] = begin_access,
    [WRITE] = begin_access,
    [PROMPT] = function(n)
      n.bus.drive = n.said.drive
      if can_answer(n) then
        answer(n, PROMPT)
        n.bus.command.end_in = packet.number
      end
      n.bus.list, n.bus.is_asked = nil, false
    end,
    [ASKS] = function(n)
      if not can_answer(n) then return end
      answer(n, ASKS)
      n.bus.command.end_in = packet.number
      n.bus.is_asked = n.bus.list ~= nil
    end,
    [ERROR] = function(n)
      local command = n.bus.command

      if not can_answer(n) then return end
      answer(n, ERROR)
      local access = command.list or command

      access.error = n.said.error
    end,
    [TEXT] = function(n)
      local command = n.bus.command

      if n.bus.is_asked and n.bus.list then
        begin_element(n)
      elseif n.said.text ~= "" and can_answer(n) and command.kind ~= OPEN then
        note_value(n)
      end
    end,
  }

  -- A limit that the bus was told holds for SIS telegrams, so only the user's counts here.
  local function find_limit(n)
    local told = n.sis_bus.told

    if not packet.record then return end
    S.bus_learn_limits(told, packet.record.known.limits)
    local limit = told.is_anything_told and S.bus_settings(told, K.ALL_STATIONS, n.times.begin)[K.TRS]

    if limit and limit.is_by_user then n.unit.limit = limit end
  end

  -- Who has sent it: one of the two lines of a tap, or ends of a connection, whose ports may be equal; 0: nobody knows.
  local function line_of(pinfo)
    if packet.record then return packet.record.line end
    if packet.port_type ~= K.PORT_TYPE_TCP then return 0 end
    if pinfo.src_port ~= pinfo.dst_port then return pinfo.src_port > pinfo.dst_port and 2 or 1 end
    return pinfo.net_dst < pinfo.net_src and 2 or 1
  end

  -- The line of this packet; found in the first pass, and kept.
  function S.ascii_find(pinfo, said, times)
    local key = packet.count * 0x100000000 + packet.number -- TCP may pack several into a packet
    local unit = units[key]

    packet.count = packet.count + 1
    if unit then return unit end
    unit = S.asked_new(times)
    unit.kind, unit.line = said.kind, line_of(pinfo)
    units[key] = unit
    if packet.visited then return unit end
    effects = effects + 1
    local bus = S.exchange_bus(pinfo)
    buses[bus] = buses[bus] or {}
    local n = {said = said, times = times, unit = unit, bus = buses[bus], sis_bus = bus}

    find_limit(n)
    if is_echo(n) then
      unit.kind, unit.command, n.bus.command.is_echoed = ECHO, n.bus.command, true
    else
      notes[said.kind](n)
    end
    unit.drive = n.bus.drive
    return unit
  end
end

--- ascii/sisascii: the ASCII protocol of ECODRIVE and IndraDrive, a line or a prompt a packet, as MPH-02 (p. 10-86 to
-- 10-91) and public clients for DKCxx.3 drives have it.

do
  local TEXT, OPEN, PROMPT, READ = K.SISASCII_TEXT, K.SISASCII_OPEN, K.SISASCII_PROMPT, K.SISASCII_READ
  local WRITE, ELEMENT, ASKS, ERROR = K.SISASCII_WRITE, K.SISASCII_ELEMENT, K.SISASCII_ASKS, K.SISASCII_ERROR
  local ECHO, ANSWER = K.SISASCII_ECHO, K.SISASCII_ANSWER
  local LARGEST_ADDRESS = 255
  local SHOWN_CHARACTERS = 80
  local find = string.find
  local ANY_TEXT = "[ -~\t\160-\255]" -- Latin-1, as drives write "°C"
  local MS = 1000000 -- in ns

  -- A drive between two words: BCD:21, E21:>.
  local function take_drive(said, kind, before, behind)
    local digits = match(said.text, "^" .. before .. "(%d%d?%d?)" .. behind .. "$")

    if not digits or tonumber(digits) > LARGEST_ADDRESS then return false end
    said.kind, said.at, said.digits, said.drive = kind, #before, #digits, tonumber(digits)
    return true
  end

  -- S-0-0051,7,R or S-0-0044,7,W,VALUE; r and w may be small.
  local function take_access(said)
    local ident, rest = S.ident_parse(said.text)
    local element, what = match(ident and rest or "", "^,([1-7]),(.*)$")
    local value = match(what or "", "^[Ww],(.*)$")

    if not value and what ~= "R" and what ~= "r" then return false end
    said.kind, said.ident, said.element = value and WRITE or READ, ident, tonumber(element)
    said.at, said.value = #said.text - #rest + 1, value
    return true
  end

  -- #7008
  local function take_error(said)
    local digits = match(said.text, "^#(%x%x%x%x)$")

    if not digits then return false end
    said.kind, said.at, said.error = ERROR, 1, tonumber(digits, 16)
    return true
  end

  local function read_line(text)
    local said = {text = text, kind = text == "?" and ASKS or TEXT}
    local _ = take_drive(said, OPEN, "BCD:", "") or take_drive(said, PROMPT, "E", ":>") or take_access(said)
      or take_error(said)

    return said
  end

  -- "-12.5", but not "0013": that is a code.
  local function is_number(text)
    return (match(text, "^%-?%d+$") or match(text, "^%-?%d+%.%d+$")) and not match(text, "^%-?0%d")
  end

  -- The command with the parameter: of an element, the write that began its list; nil: it has none.
  local function access_of(command)
    local access = command and (command.list or command)

    return access and access.kind ~= OPEN and access or nil
  end

  -- When the command was sent.
  local function known_of(access)
    return access.body and S.learned_known(access.body, access.said.ident, access.drive)
      or S.known_from_tables(access.said.ident)
  end

  local function with_unit(value, known)
    return (known.unit or "") ~= "" and value .. " " .. known.unit or value
  end

  -- A value of bits is hexadecimal (0x0010, 10h) or binary (11b), or its attribute says which: its digits, and the
  -- bits of each. Nil: it is neither, or has more than 64 bits.
  local function read_bits(text, known)
    local format = known.attribute and floor(known.attribute / 2 ^ 20) % 8
    local is_hexadecimal = match(text, "^0x") or match(text, "h$") or format == K.FORMAT_HEXADECIMAL
    local is_binary = match(text, "b$") or format == K.FORMAT_BINARY
    local digits = is_hexadecimal and match(gsub(text, "^0x", ""), "^(%x+)h?$")
      or not is_hexadecimal and is_binary and match(text, "^([01]+)b?$")
    local width = is_hexadecimal and 4 or 1

    if digits and #digits <= 64 / width then return digits, width end
  end

  -- The bits that are set and have a name.
  local function add_named_bits(line, item, offset, length, value, known)
    local digits, width = read_bits(value, known)

    if not digits or not known.bits then return end
    for number, name in string.gmatch(known.bits, "(%d+)=([^,]+)") do
      local place = floor(number / width)
      local digit = tonumber(sub(digits, -1 - place, -1 - place), 16) or 0

      if floor(digit / 2 ^ (number % width)) % 2 == 1 then
        add(item, F.value_bit, line.tvb, offset, length, name, "Bit " .. number .. ": " .. name)
      end
    end
  end

  -- Operating data and limits have the unit of the parameter.
  local function show_value(line, offset, value, access, known)
    local length = line.length - offset
    local is_value = access.said.element >= K.ELEMENT_MINIMUM and is_number(value)
    local shown = is_value and with_unit(value, known) or value

    local item = add(line.tree, F.value, line.tvb, offset, length, shown)

    line.words = line.words .. " = " .. shown
    if access.said.element >= K.ELEMENT_MINIMUM then
      add_named_bits(line, item or line.tree, offset, length, value, known)
    end
    if is_value then
      set_generated(add(line.tree, F.value_number, line.tvb, offset, length, S.shown_number(value),
        "Number: " .. value))
    end
  end

  -- The parameter of a command, or of the command that a line belongs to.
  local function show_parameter(line, access, known)
    local ident, element, is_here = access.said.ident, access.said.element, line.said.kind == access.said.kind

    if line.tree then S.add_ident(line.tree, line.tvb, {offset = 0, length = 0}, ident, known) end
    local item = add(line.tree, FX.sisascii_element, line.tvb, is_here and line.said.at or 0, is_here and 1 or 0,
      element)

    if not is_here then set_generated(item) end
    if line.unit.kind == ECHO then return end
    line.words = line.words .. " " .. ident.text .. (known.name and " (" .. known.name .. ")" or "")
    if element ~= K.ELEMENT_DATA then line.words = line.words .. ", " .. string.lower(N.elements[element]) end
  end

  -- Codes of its own, else those of parameter services.
  local function error_text(code)
    return N.errors_ascii[code] or N.errors_parameter[code] or "Not defined"
  end

  local function show_error(line)
    local code = line.said.error
    local text = error_text(code)
    local item = add_value(line.tree, F.error, line.tvb, line.said.at, 4, code, "%s (0x%04x)", text, code)

    add_expert(item or line.root, E.status_execution_error, strformat("error 0x%04x: %s", code, text))
    line.words = line.words .. strformat(": 0x%04x %s", code, text)
  end

  -- Which drive a line is for; at that place if it says so itself.
  local function show_drive(line)
    local said = line.said
    local is_here = said.drive ~= nil and line.unit.kind ~= ECHO
    local drive = is_here and said.drive or line.unit.drive

    if not drive then return end
    local item = add(line.tree, FX.sisascii_drive, line.tvb, is_here and said.at or 0, is_here and said.digits or 0,
      drive)

    if is_here then line.words = strformat(" %d", drive) else set_generated(item) end
    set_hidden(add_generated(line.tree, F.station, line.tvb, drive))
  end

  local function show_line(line)
    local unit = line.unit
    local access, kind = access_of(unit.command), unit.kind
    local known

    if access and kind ~= PROMPT then
      known = known_of(access)
      show_parameter(line, access, known)
    end
    add_generated(line.tree, FX.sisascii_index, line.tvb, unit.index)
    if kind == WRITE and line.said.value == ">" then
      line.words = line.words .. ", a list"
    elseif kind == WRITE then
      show_value(line, line.said.at + 4, line.said.value, access, known)
    elseif kind == ANSWER or kind == ELEMENT then
      show_value(line, 0, line.said.text, access, known)
    elseif kind == ERROR then
      show_error(line)
    elseif kind == TEXT or kind == ECHO then
      add(line.tree, FX.sisascii_text, line.tvb, 0, line.length, line.said.text)
      line.words = line.words .. strformat(' "%s"', line.said.text)
    end
  end

  local function show_verdict(line, limit_ms, source)
    local verdict = S.judge(line.unit.span, limit_ms * MS)

    S.add_time(line.tree, F.trs_limit, line.tvb, limit_ms * MS, "%s ms%s", limit_ms, source)
    if source ~= "" then add_generated(line.tree, F.trs_set_in, line.tvb, line.unit.limit.set_in) end
    local item = add_generated(line.tree, F.trs_verdict, line.tvb, verdict)

    if verdict == K.TIME_EXCEEDED then
      add_expert(item or line.root, E.trs_exceeded)
      line.marks = line.marks .. "  [TrS exceeded]"
    elseif verdict == K.TIME_UNRESOLVED then
      add_expert(item or line.root, E.trs_unresolved)
    end
  end

  -- How long the drive took. No document has a limit, so it is the user's.
  local function show_time(line)
    local unit, times = line.unit, line.times

    if not unit.request_in then return end
    if line.tree and S.is_measured(unit.elapsed, times) then
      S.add_ms(line.tree, F.reaction_time, line.tvb, unit.elapsed)
      S.add_column_ms(line.tree, F.reaction_time_ms, line.tvb, unit.elapsed)
    end
    if not times.record then return end
    if P.trs_ms > 0 then
      show_verdict(line, P.trs_ms, "")
    elseif unit.limit then
      show_verdict(line, unit.limit.value, ", told by the user")
    end
  end

  local function show_command(line, command)
    add_generated(line.tree, F.reaction_in, line.tvb, command.asked.answer_in)
    add_generated(line.tree, F.repeat_of, line.tvb, command.repeat_of)
    add_generated(line.tree, F.unanswered_before, line.tvb, command.unanswered_before)
    add_generated(line.tree, F.next_command_in, line.tvb, command.next_in)
    if command.repeat_of then
      add_expert(line.root, E.command_repeat)
      line.marks = line.marks .. "  [repeat]"
    end
    if command.next_in then
      add_expert(line.root, E.command_unanswered)
      line.marks = line.marks .. "  [no reaction]"
    end
  end

  local function show_links(line)
    local command = line.unit.command

    if not command then return end
    if line.unit.is_command then
      show_command(line, command)
      return
    end
    add_generated(line.tree, F.command_in, line.tvb, command.asked.frame)
    show_time(line)
  end

  local function set_value(access, command)
    local value = concat(command.values, ", ")

    if #command.values == 0 then return end
    access.text = value
    if #command.values == 1 and is_number(value) then
      access.number = value
      value = with_unit(value, access.known)
    end
    access.value = S.shortened(value, SHOWN_CHARACTERS)
  end

  -- The line that ends an answer completes a read or write of operating data.
  local function tell_access(line)
    local command = access_of(line.unit.command)

    if line.unit.kind ~= PROMPT or not command or not command.drive or command.said.element ~= K.ELEMENT_DATA
      or not S.is_access_wanted(line.tree) then
      return
    end
    local ident, drive, code = command.said.ident, command.drive, command.error
    local access = {
      is_write = command.kind == WRITE,
      error = code and strformat("0x%04x %s", code, error_text(code)),
      station = strformat("%d", drive),
      device = drive,
      ident = ident,
      known = S.learned_complete(command.body, ident, drive, known_of(command)),
    }

    if not code then set_value(access, command) end
    S.tell_access(access, line.tvb, line.tree)
  end

  -- For S.segments_dissect(). Who ends lines with CR alone waits for the answer, so LF is not waited for. A line that
  -- the capture has cut has the rest of the segment.
  local function line_length(bytes, pinfo, offset, reported)
    local there, first = min(#bytes - offset, K.SISASCII_MOST_LINE), offset + 1
    local _, last = find(bytes, "^%?", first)

    if not last then _, last = find(bytes, "^E%d%d?%d?:>", first) end
    if last then return last - offset end
    _, last = find(bytes, "^" .. ANY_TEXT .. "*", first)
    if last - offset >= K.SISASCII_MOST_LINE then return K.SISASCII_MOST_LINE end
    if last - offset == there then return pinfo.can_desegment > 0 and 0 or reported - offset end
    local _, line_end = find(bytes, "^\r?\n?", last + 1)

    if line_end == last then _, line_end = find(bytes, "^[^" .. sub(ANY_TEXT, 2, -2) .. "\r\n]+", last + 1) end
    return min(line_end - offset, there)
  end

  -- Cut by the capture, or noise of the line: it may have said something else.
  local function is_whole(bytes, there)
    return #bytes == there and (#bytes == 0 or find(bytes, "[" .. sub(ANY_TEXT, 2, -2) .. "\r\n]$") ~= nil)
  end

  local function dissect_line(tvb, pinfo, tree, there)
    local root = tree and tree:add(sisascii, tvb())
    local whole = raw(tvb)
    local bytes = match(whole, "^(.-)[\r\n]*$")
    local line = {tvb = tvb, tree = root, root = root, length = #bytes, words = "", marks = "",
      times = S.times(tvb, there, there)}

    if is_whole(whole, there) then
      line.said = read_line(S.text(bytes))
      line.unit = S.ascii_find(pinfo, line.said, line.times)
    else
      line.said, line.unit = {text = S.text(bytes)}, {kind = TEXT}
    end
    add_generated(root, FX.sisascii_kind, tvb, line.unit.kind)
    show_drive(line)
    show_line(line)
    show_links(line)
    tell_access(line)
    local words = N.ascii_kinds[line.unit.kind] .. line.words
    local cols = pinfo.cols

    append_text(root, ", " .. words)
    cols.protocol = "SISASCII"
    cols.info:clear()
    cols.info:append(S.separator(cols.info) .. words .. line.marks)
    return tvb:len()
  end

  -- LF alone may belong to the line before, whose CR ended it; an empty line says nothing.
  local function dissect_tcp_line(tvb, pinfo, tree, there)
    if find(tvb:raw(), "[^\r\n]") then
      dissect_line(tvb, pinfo, tree, there)
      if tvb:len() < there then S.show_cut(tvb, pinfo, tree, "SISASCII") end
      pinfo.cols.info:fence()
    end
    return tvb:len()
  end

  local function dissect_tcp(tvb, pinfo, tree)
    S.begin_packet(pinfo)
    S.segments_dissect(tvb, pinfo, tree, line_length, dissect_tcp_line, "SISASCII")
  end

  -- A segment that begins with a whole command: no other protocol has such lines.
  local function dissect_heuristic(tvb, pinfo, tree)
    local bytes = tvb:raw()
    local length = P.tcp_heuristic and line_length(bytes, pinfo, 0, tvb:reported_len()) or 0
    local text, line_end = match(sub(bytes, 1, length), "^(.-)([\r\n]*)$")
    local kind = line_end ~= "" and read_line(S.text(text)).kind

    return (kind == OPEN or kind == READ or kind == WRITE) and S.recognize(tvb, pinfo, tree, sisascii, dissect_tcp)
  end

  sisascii:register_heuristic("tcp", dissect_heuristic)

  function sisascii.dissector(tvb, pinfo, tree)
    if pinfo.port_type ~= 0 and S.is_before(pinfo) then return 0 end
    if pinfo.port_type == K.PORT_TYPE_TCP then
      dissect_tcp(tvb, pinfo, tree)
    else
      S.begin_packet(pinfo)
      dissect_line(tvb, pinfo, tree, T.reported_len(tvb))
    end
    return tvb:len()
  end
end

--- sis/transports: where SIS telegrams come from besides the serial tap: TCP, UDP, RTAC serial captures

do
  local SIP_PORT = 35021 -- S/IP, another protocol of the same drives

  local NO_TELEGRAM, GOOD, DAMAGED, INCOMPLETE = 0, 1, 2, 3

  -- The data that TCP hands over together; whether it may be asked for more.
  local data, can_wait

  -- What seems to begin at offset, judging by the available bytes.
  local function examine(offset)
    local there, declared = #data - offset, S.declared_length(data, offset)

    if byte(data, offset + 1) ~= K.START or (there >= 4 and declared == 0) then return NO_TELEGRAM, declared end
    if there < 4 or declared > there then return INCOMPLETE, declared end
    if S.is_good(data, offset) then return GOOD, declared end
    if declared == there then can_wait = false end
    return DAMAGED, declared
  end

  -- For S.segments_dissect(): the length of the telegram at offset; 0 if more bytes are needed. Without a telegram (a
  -- segment was lost, the capture began in the middle): the length up to the next one. A damaged telegram also ends
  -- where another one begins: if a character was lost, its length counts the first one of the next.
  local function telegram_length(bytes, _, offset, there)
    data = bytes
    local first, declared = examine(offset)
    local rest, start = there - offset, offset + 1

    if first == GOOD or (first == INCOMPLETE and can_wait) then return declared end
    if first == DAMAGED then rest = declared end
    while true do
      start = string.find(data, char(K.START), start + 1, true)
      if not start or start - 1 - offset >= rest then return rest end
      local other, length = examine(start - 1)
      local is_awaited = other == INCOMPLETE and (first ~= DAMAGED or length > 0)

      if other == GOOD or (is_awaited and can_wait) then return start - 1 - offset end
    end
  end

  -- SIS writes the columns only if a telegram ends here; TCP describes a segment with just a part. The fence keeps
  -- the text of earlier telegrams.
  local function dissect_pdu(tvb, pinfo, tree, there)
    local cols = pinfo.cols

    cols.protocol = "SIS"
    cols.info:clear()
    local words = S.dissect_telegram(tvb, tvb:raw(), pinfo, tree, there)
    cols.info:append(S.separator(cols.info) .. words)
    if tvb:len() < there then S.show_cut(tvb, pinfo, tree, "SIS") end
    cols.info:fence()
    return tvb:len()
  end

  -- Telegrams split over segments and packed into them.
  local function dissect_segment(tvb, pinfo, tree)
    S.begin_packet(pinfo)
    can_wait = pinfo.can_desegment > 0
    S.segments_dissect(tvb, pinfo, tree, telegram_length, dissect_pdu, "SIS")
  end

  -- USIP and others also start with 0x02. So only a whole telegram with equal lengths and a zero checksum counts, and
  -- another one must follow it.
  local function is_sis(bytes)
    local declared = S.declared_length(bytes, 0)

    return S.is_good(bytes, 0) and (declared == #bytes or byte(bytes, declared + 1) == K.START)
  end

  local function dissect_tcp_heuristic(tvb, pinfo, tree)
    local bytes = tvb:raw()

    S.segments_look(bytes, pinfo)
    if not P.tcp_heuristic or pinfo.src_port == SIP_PORT or pinfo.dst_port == SIP_PORT or not is_sis(bytes) then
      return false
    end
    return S.recognize(tvb, pinfo, tree, sis, dissect_segment)
  end

  local function dissect_udp_heuristic(tvb, pinfo, tree)
    return P.udp_heuristic and is_sis(tvb:raw()) and S.recognize(tvb, pinfo, tree, sis, S.dissect_packet)
  end

  S.dissect_segment = dissect_segment

  for name, proto in pairs(protos) do
    proto.fields, proto.experts = registered[name].fields, registered[name].experts
  end

  DissectorTable.get("sertap.framing"):add(0, sis)
  DissectorTable.get("sertap.framing"):add(1, p3964r)
  DissectorTable.get("sertap.framing"):add(2, sisascii)
  DissectorTable.get("tcp.port"):add_for_decode_as(sis)
  DissectorTable.get("tcp.port"):add_for_decode_as(sisascii)
  DissectorTable.get("udp.port"):add_for_decode_as(sis)
  DissectorTable.get("rtacser.data"):add_for_decode_as(sis)
  sis:register_heuristic("tcp", dissect_tcp_heuristic)
  sis:register_heuristic("udp", dissect_udp_heuristic)
end
