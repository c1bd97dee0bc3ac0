-- SPDX-License-Identifier: GPL-2.0-or-later
-- The SIS telegram and the serial tap's record in Lua: one file for Wireshark 4.0 and later, no compiler. Put it into
-- the personal plugin folder (Help > About Wireshark > Folders).
--
-- It shows what the C plugin in plugin/ shows, and is written like it: a block a file, in the same order, with the same
-- names. Where a block says nothing, the comments of its C file hold. README.md lists what Lua cannot do.

-- head: guards, aliases, and what all blocks use

if tonumber(string.match(get_version(), "^%d+")) < 4 then
  error("sis.lua needs Wireshark 4.0 or later, this is " .. get_version(), 0)
end

-- The C plugin, which Wireshark loads first, or another copy of this file: it has all that this one has.
for _, name in ipairs(Dissector.list()) do
  if name == "sis" or name == "sertap" then
    io.stderr:write("sis.lua: " .. name .. " is there already, so this copy does nothing\n")
    return
  end
end

local floor, fmod, max, min = math.floor, math.fmod, math.max, math.min
local byte, char, rep, sub, strformat = string.byte, string.char, string.rep, string.sub, string.format
local concat, unpack = table.concat, table.unpack
local band, bxor, lshift, rshift = bit.band, bit.bxor, bit.lshift, bit.rshift -- signed: up to 31 bits only

local sertap = Proto("sertap", "Serial tap")
local sis = Proto("sis", "Rexroth SIS serial protocol")

-- What crosses blocks, named as in the C headers: S.take for sis_take(), T.record for sertap_record().
local S, T = {}, {}
-- Fields and expert items of sis, and of sertap: F.service for hf_sis_service, E.missing for ei_sis_missing.
local F, FT, E, ET = {}, {}, {}, {}
-- Constants; texts by code; values of the preferences of sis.
local K, N, P = {}, {}, {}

K.PORT_TYPE_TCP = 2 -- of pinfo.port_type; 0: the packet has no ports

local label = {} -- of a field

-- Declares a field: `name` in F, or in FT where it belongs to sertap.
local function field(name, text, abbreviation, kind, display, strings, mask, description)
  local made = ProtoField.new(text, abbreviation, kind, strings, display, mask, description)

  label[made] = text
  if sub(abbreviation, 1, 4) == "sis." then F[name] = made else FT[name] = made end
end

-- Declares an expert item; group and severity as Wireshark's Lua names them.
local function expert_field(name, abbreviation, group, severity, text)
  local made = ProtoExpert.new(abbreviation, text, expert.group[group], expert.severity[severity])

  if sub(abbreviation, 1, 4) == "sis." then E[name] = made else ET[name] = made end
end

-- Declares a preference of sis: P[name] has its value.
local function preference(name, made)
  sis.prefs[name] = made
  P[name] = sis.prefs[name]
end

local function read_preferences()
  for name in pairs(P) do
    P[name] = sis.prefs[name]
  end
end

sis.prefs_changed = read_preferences

-- What a file leaves behind goes when the next one is opened.
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

-- Items of the tree. Without a tree, and for an item that is not there, all of them do nothing.

-- A field with its value, or with that of its bytes, big endian; `text` in place of all that is shown of it.
local function add(tree, which, tvb, offset, length, value, text)
  if tree == nil then
    return nil
  elseif text ~= nil then
    return tree:add(which, tvb(offset, length), value, text)
  elseif value ~= nil then
    return tree:add(which, tvb(offset, length), value)
  end
  return tree:add(which, tvb(offset, length))
end

-- The same with the bytes as little endian.
local function add_le(tree, which, tvb, offset, length)
  return tree and tree:add_le(which, tvb(offset, length))
end

-- A field with its value and `text` after its name.
local function add_value(tree, which, tvb, offset, length, value, text)
  return tree and tree:add(which, tvb(offset, length), value, label[which] .. ": " .. text)
end

-- A line that is no field.
local function add_subtree(tree, tvb, offset, length, text)
  return tree and tree:add(tvb(offset, length), text)
end

local function append_text(item, text)
  if item then item:append_text(text) end
end

local function set_generated(item)
  return item and item:set_generated()
end

-- An expert item; its declared text where there is no other.
local function add_expert(item, which, text)
  if text then item:add_proto_expert_info(which, text) else item:add_proto_expert_info(which) end
end

-- ns as Wireshark's time.
local function nstime(ns)
  local rest = fmod(ns, 1e9)

  return NSTime.new((ns - rest) / 1e9, rest)
end

local function plural(count)
  return count == 1 and "" or "s"
end

-- What Wireshark says where the capture has cut a packet. Lua cannot throw its exception.
function S.show_cut(tvb, pinfo, parent, name)
  parent:add(tvb(0, 0), "[Packet size limited during capture: " .. name .. " truncated]")
  pinfo.cols.info:append("[Packet size limited during capture]")
end

-- "02 5e".
local function hex(bytes)
  local spaced = string.gsub(bytes, ".", function(c) return strformat("%02x ", byte(c)) end)

  return sub(spaced, 1, -2)
end

-- The text of a value in ranges {first, last, text}: the first that fits; nil where none does.
local function range_text(value, ranges)
  for _, range in ipairs(ranges) do
    if value >= range[1] and value <= range[2] then
      return range[3], range
    end
  end
end

-- Which interface of the capture a packet came from; 0 where there is none, and in the first of two passes of tshark,
-- which has no fields for Lua unless a filter wants some.
local frame_interface_id = Field.new("frame.interface_id")
local interface_of, interface_id -- of the packet that was asked for last: every field that is looked at costs time

at_init(function() interface_of = nil end)

function S.interface(pinfo)
  local number = pinfo.number

  if number ~= interface_of then
    local found = frame_interface_id()

    interface_of, interface_id = number, found and found.value or 0
  end
  return interface_id
end

-- Which TCP connection a packet belongs to: its two ends, as text. Its number is a field, and the first pass of tshark
-- has none.
function S.connection(pinfo)
  local one = tostring(pinfo.net_src) .. " " .. pinfo.src_port
  local other = tostring(pinfo.net_dst) .. " " .. pinfo.dst_port

  return one < other and one .. " " .. other or other .. " " .. one
end

-- When a packet came: ns since the first packet. Lua has the time since 1970 as a double of seconds, too coarse for ns;
-- that since the first packet is exact for weeks. It changes with a time reference that the user sets, so the one of
-- the first pass is kept.
local packet_times = {}

at_init(function() packet_times = {} end)

function S.packet_time(pinfo)
  local number = pinfo.number
  local time = packet_times[number]

  if not time then
    time = floor(pinfo.rel_ts * 1e9 + 0.5)
    packet_times[number] = time
  end
  return time
end

-- Each block stands in do ... end: Lua allows 200 locals at a time.
