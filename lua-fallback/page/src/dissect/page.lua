-- SPDX-License-Identifier: GPL-2.0-or-later
-- What the page needs of Wireshark beside sis.lua. Loaded before it.

-- In its first pass wiregasm makes no fields, and Wireshark itself makes them. sis.lua asks for three: section and
-- interface of a packet, and on ARCNET its bytes. The page has written them into a file, a line for each packet.
local TOLD, CAPTURE = "/told", "/uploads/capture"
local FIELDS = {["frame.section_number"] = 1, ["frame.interface_id"] = 2, ["frame"] = 3}
local told, capture -- files
local line, at -- of the file, and the packet that it is of
local packet -- the last one of the first pass

local page = Proto("page", "Page")

page.prefs.experts = Pref.bool("List the expert items", false, "When taps are drawn, into the file /experts")

local function bytes_of(place, length)
  capture:seek("set", tonumber(place))
  return capture:read(tonumber(length))
end

local function value_of(which)
  local section, interface, place, length = line:match("^(%d+) (%d+) ?(%d*) ?(%d*)$")

  if which == 1 then return {value = section + 1} end
  if which == 2 then return {value = math.tointeger(tonumber(interface))} end
  if place == "" then return nil end
  return {range = function(begin)
    return {tvb = function() return ByteArray.new(bytes_of(place, length):sub(begin + 1), true):tvb("Frame") end}
  end}
end

local make_field = Field.new

Field.new = function(name)
  local field, which = make_field(name), FIELDS[name]

  if not which then return field end
  return function()
    local found = field()

    if found or not told then return found end
    while line and at <= packet do line, at = told:read(), at + 1 end
    return line and value_of(which)
  end
end

-- sis.lua lets garbage lie, because that is quick. In a page it would fill the 2 GB that WebAssembly has.
local ROOM = 128 * 1024 -- kB of garbage
local most = ROOM

local function collect()
  if collectgarbage("count") < most then return end
  collectgarbage()
  most = collectgarbage("count") + ROOM
end

-- wiregasm does not tell which fields are generated. The page reads it in a file, a line for each of them. Only the tree of
-- a packet that the page asks for is visible.
local function tell_generated()
  local found = {}

  for _, field in ipairs({all_field_infos()}) do
    if field.generated then
      local length = field.len

      found[#found + 1] = ("%s %d %d\n"):format(field.name, length == 0 and 0 or field.offset, length) -- as in wiregasm's tree
    end
  end
  local file = io.open("/generated", "w")

  file:write(table.concat(found))
  file:close()
end

function page.dissector(_, pinfo, tree)
  if not pinfo.visited then packet = pinfo.number end
  if tree.visible then tell_generated() end
  collect()
end

register_postdissector(page)

-- The expert items of all packets: severity, group, text and number of the packet, when taps are drawn.
local severity, group, message = make_field("_ws.expert.severity"), make_field("_ws.expert.group"),
  make_field("_ws.expert.message")
local is_listening = false

local function listen()
  local tap, found = Listener.new("frame", "_ws.expert"), {}

  function tap.packet(pinfo)
    local severities, groups, messages = {severity()}, {group()}, {message()}

    for index, text in ipairs(messages) do
      found[#found + 1] = table.concat({severities[index].display, groups[index].display, pinfo.number,
        (tostring(text):gsub("[\t\n]", " "))}, "\t")
    end
  end

  function tap.draw()
    local file = io.open("/experts", "w")

    file:write(table.concat(found, "\n"))
    file:close()
  end

  function tap.reset() found = {} end
end

function page.init()
  for _, file in pairs({told, capture}) do file:close() end
  told = io.open(TOLD)
  capture = told and io.open(CAPTURE, "rb")
  packet, line, at = 0, told and told:read(), 1
  if page.prefs.experts and not is_listening then
    is_listening = true
    listen()
  end
end
