-- SPDX-License-Identifier: GPL-2.0-or-later
-- What the lanes of the page draw of each telegram: when taps are drawn, it is in the file /lanes. Loaded after sis.lua,
-- because it reads its fields. The rules that colour the packet list say what a telegram is.
local RULES = "/home/web_user/.config/wireshark/colorfilters" -- PROFILE of dissector.js
local UNANSWERED = "sis.command.unanswered"
local RECORD = "<dfI4I2I2I2" -- as in records.js: time and duration in s, packet, talker, listener, a bit for each rule
local NOBODY = 0xffff
local BITS = 11 -- of a character of 8E1: a bar is a picture, no measure

local lanes = Proto("page_lanes", "Lanes of the page")
local talker, listener = Field.new("sis.talker"), Field.new("sis.listener")
local count, baud = Field.new("sertap.count"), Field.new("sertap.baud")
local is_listening = false

lanes.prefs.on = Pref.bool("Note what the lanes draw", false, "When taps are drawn, into the file /lanes")

-- The filters of the rules, in their order, and last the one of commands that got no answer.
local function filters()
  local found = {}

  for line in io.lines(RULES) do found[#found + 1] = line:match("^@[^@]*@(.*)@%[") end
  found[#found + 1] = UNANSWERED
  return found
end

local function duration()
  local characters, rate = count(), baud()

  if not characters or not rate or rate.value == 0 then return 0 end
  return characters.value * BITS / rate.value
end

local function listen()
  local records, bits = {}, {} -- without their bits; bits by packet
  local tap = Listener.new("frame")

  function tap.packet(pinfo)
    local talkers, listeners, begin, lasts, number = {talker()}, {listener()}, pinfo.rel_ts, duration(), pinfo.number

    for place = 1, math.max(#talkers, 1) do
      local from, to = talkers[place], listeners[place]
      records[#records + 1] = {begin, lasts, number, from and from.value or NOBODY, to and to.value or NOBODY}
    end
  end

  function tap.draw()
    local file = io.open("/lanes", "wb")

    for _, record in ipairs(records) do
      file:write(RECORD:pack(record[1], record[2], record[3], record[4], record[5], bits[record[3]] or 0))
    end
    file:close()
  end

  function tap.reset() records, bits = {}, {} end

  for place, filter in ipairs(filters()) do
    local bit = 1 << place - 1

    Listener.new("frame", filter).packet = function(pinfo)
      bits[pinfo.number] = (bits[pinfo.number] or 0) | bit
    end
  end
end

function lanes.init()
  if lanes.prefs.on and not is_listening then
    is_listening = true
    listen()
  end
end
