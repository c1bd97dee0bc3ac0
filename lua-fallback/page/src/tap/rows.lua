-- SPDX-License-Identifier: GPL-2.0-or-later
-- What `tshark -T fields` prints: a line of values for each packet of the second pass, in the file /rows. The file
-- /wanted has what joins several values, then the names of fields. Lua knows no expert items of scripts: their names go
-- into the file /others.
local wanted, others = io.lines("/wanted"), io.open("/others", "w")
local joint, fields = wanted(), {}

for name in wanted do
  local is_known, field = pcall(Field.new, name)

  if is_known then fields[#fields + 1] = field else others:write(name, "\n") end
end
others:close()

local ESCAPES = {["\\"] = "\\\\", ["\a"] = "\\a", ["\b"] = "\\b", ["\f"] = "\\f", ["\n"] = "\\n", ["\r"] = "\\r",
  ["\t"] = "\\t", ["\v"] = "\\v"}
local rows = Proto("page_rows", "Rows of the page")
local file

function rows.init()
  if file then file:close() end
  file = io.open("/rows", "a")
  file:setvbuf("no")
end

local function text_of(values)
  for place, value in ipairs(values) do
    values[place] = tostring(value):gsub("[\\%c]", ESCAPES)
  end
  return table.concat(values, joint)
end

function rows.dissector(_, pinfo)
  if not pinfo.visited then return end
  local line = {pinfo.number}

  for place, field in ipairs(fields) do line[place + 1] = text_of({field()}) end
  file:write(table.concat(line, "\t"), "\n")
end

register_postdissector(rows)
