
-- sertap-line: what is known of a line, record after record, in the first pass

do
  local WINDOW_NS = 1e9 -- over which the load is taken
  local SHORTEST_FRAME = 8 -- fewer other characters are what a line says when its direction turns

  local lines = {} -- by interface

  at_init(function() lines = {} end)

  local function find_line(pinfo)
    local key = S.interface(pinfo)
    local line = lines[key]

    if not line then
      -- The spells of the last window are those from `head` to `last`; `busy` is the time of all of them, in ns.
      line = {lost_in = 0, unframed_in = 0, spells = {}, head = 1, last = 0, busy = 0, begin = 0}
      lines[key] = line
    end
    return line
  end

  -- What may hide a frame: the last loss of characters, and the last that may have been a frame; 0 where there is none.
  function T.disturbance(record)
    return record.known
  end

  local function note_disturbance(line, pinfo, record)
    local is_gap = record.type == K.EVENT
      and (record.event == K.CHARACTERS_LOST or record.event == K.ADAPTER_LOST)

    if is_gap or band(record.flags, K.LOST_BEFORE) ~= 0 then line.lost_in = pinfo.number end
    if record.type == K.OTHER and record.count >= SHORTEST_FRAME then line.unframed_in = pinfo.number end
  end

  local function note_spell(line, pinfo, record)
    local character = T.character_ns(record)
    local busy = character * record.count
    local finish = S.packet_time(pinfo) + record.duration
    local begin = finish - max(busy, record.duration + character)
    local spells = line.spells

    if busy == 0 then return end
    if line.last == 0 then line.begin = begin end
    line.last = line.last + 1
    spells[line.last] = {begin, finish, busy}
    line.busy = line.busy + busy
    while spells[line.head][2] <= finish - WINDOW_NS do
      line.busy = line.busy - spells[line.head][3]
      spells[line.head] = nil
      line.head = line.head + 1
    end
  end

  function T.line_note(pinfo, record)
    local line = find_line(pinfo)

    record.known = line
    if record.flags ~= 0 or record.type ~= K.FRAME then note_disturbance(line, pinfo, record) end
    if record.type ~= K.EVENT then note_spell(line, pinfo, record) end
  end

  -- How long the line was busy, of how much time, both in ns; nothing where that is not known. Of the oldest spell only
  -- a part may lie in the window.
  function T.load(record)
    local line = record.known
    local first, last = line.spells[line.head], line.spells[line.last]

    if not first then return end
    local busy, begin = line.busy, max(last[2] - WINDOW_NS, line.begin)
    if first[1] < begin then
      busy = busy - floor(first[3] * (begin - first[1]) / (first[2] - first[1]))
    end
    return busy, last[2] - begin
  end

  -- The double nearest to x that C's float can hold: the plugin keeps the load in one.
  local function single(x)
    local scaled = x * 536870913.0 -- 2^29 + 1

    return scaled - (scaled - x)
  end

  -- What T.load() gave, in percent.
  function T.percent(busy, span)
    return single(min(max(single(single(busy) / single(span)), 0), 1) * 100)
  end
end

-- packet-sertap: the serial tap's link layer: one record a packet, with value, interval and flags of every character

do
  local RECORD_VERSION, RECORD_HEADER_SIZE = 1, 20
  local FRAMING_SIS = 0
  local UNCERTAINTY_UNKNOWN = 0xFFFFFFFF

  K.FRAME, K.OTHER, K.EVENT = 0, 1, 2
  K.CHARACTERS_LOST, K.ADAPTER_LOST = 3, 4
  K.SAME_READ, K.CHARACTER_ERROR, K.BREAK, K.LOST_BEFORE = 0x01, 0x02, 0x04, 0x08
  K.UNLOCATED_ERROR, K.INTERVAL_UNKNOWN, K.INTERVAL_SATURATED = 0x10, 0x20, 0x40

  local types = {[K.FRAME] = "Frame", [K.OTHER] = "Other characters", [K.EVENT] = "Event"}
  local line_names = {[0] = "Shared bus", [1] = "First direction", [2] = "Second direction"}
  local parities = {[0] = "None", [1] = "Even", [2] = "Odd", [3] = "Mark", [4] = "Space"}
  local parity_letters = {[0] = "N", [1] = "E", [2] = "O", [3] = "M", [4] = "S"}
  local stop_bits = {[2] = "1", [3] = "1.5", [4] = "2"}
  local framings = {[FRAMING_SIS] = "SIS", [1] = "3964R", [255] = "Silence"}
  local events = {
    [0] = "None",
    [1] = "Capture started",
    [2] = "Line settings changed",
    [K.CHARACTERS_LOST] = "Characters lost",
    [K.ADAPTER_LOST] = "Adapter lost",
    [5] = "Marker",
    [6] = "Capture ended",
  }

  field("version", "Version", "sertap.version", ftypes.UINT8, base.DEC)
  field("header_length", "Header length", "sertap.header_length", ftypes.UINT8, base.DEC)
  field("type", "Type", "sertap.type", ftypes.UINT8, base.DEC, types)
  field("line", "Line", "sertap.line", ftypes.UINT8, base.DEC, line_names)
  field("baud", "Baud rate", "sertap.baud", ftypes.UINT32, base.DEC)
  field("format", "Character format", "sertap.format", ftypes.STRING)
  field("data_bits", "Data bits", "sertap.format.data_bits", ftypes.UINT8, base.DEC)
  field("parity", "Parity", "sertap.format.parity", ftypes.UINT8, base.DEC, parities)
  field("stop_bits", "Stop bits", "sertap.format.stop", ftypes.UINT8, base.DEC, stop_bits, 0, "In half bits")
  field("framing", "Framing", "sertap.framing", ftypes.UINT8, base.DEC, framings, 0, "By which rule frames are cut")
  field("uncertainty", "Uncertainty of the times", "sertap.uncertainty", ftypes.RELATIVE_TIME, nil, nil, 0,
    "How much earlier than recorded a character can have arrived")
  field("count", "Count", "sertap.count", ftypes.UINT16, base.DEC, nil, 0, "Characters, or bytes of an event's text")
  field("event", "Event", "sertap.event", ftypes.UINT16, base.DEC, events)
  field("text", "Text", "sertap.text", ftypes.STRING)
  field("data", "Characters", "sertap.data", ftypes.BYTES)
  field("character", "Character", "sertap.character", ftypes.UINT8, base.HEX)
  field("interval", "Interval", "sertap.interval", ftypes.RELATIVE_TIME, nil, nil, 0,
    "Since the character before it on this line, arrival to arrival")
  field("interval_max", "Longest interval", "sertap.interval.max", ftypes.RELATIVE_TIME, nil, nil, 0,
    "Between two characters of this record")
  field("flags", "Flags", "sertap.flags", ftypes.UINT8, base.HEX)
  field("same_read", "Came in the same read as the one before", "sertap.same_read", ftypes.BOOLEAN, 8, nil, K.SAME_READ)
  field("error_character", "Parity or framing error", "sertap.error.character", ftypes.BOOLEAN, 8, nil,
    K.CHARACTER_ERROR)
  field("error_break", "Break", "sertap.error.break", ftypes.BOOLEAN, 8, nil, K.BREAK)
  field("error_lost", "Characters lost before it", "sertap.error.lost", ftypes.BOOLEAN, 8, nil, K.LOST_BEFORE)
  field("error_unlocated", "Error somewhere in its read", "sertap.error.unlocated", ftypes.BOOLEAN, 8, nil,
    K.UNLOCATED_ERROR)
  field("interval_unknown", "Interval unknown (first on the line)", "sertap.interval.unknown", ftypes.BOOLEAN, 8, nil,
    K.INTERVAL_UNKNOWN)
  field("interval_saturated", "Interval longer than it can be stored", "sertap.interval.saturated", ftypes.BOOLEAN, 8,
    nil, K.INTERVAL_SATURATED)

  expert_field("version", "sertap.version.unknown", "MALFORMED", "ERROR", "Unknown version of the record")
  expert_field("header_length", "sertap.header_length.short", "MALFORMED", "ERROR",
    "The header is shorter than version 1 has it")
  expert_field("count", "sertap.count.wrong", "MALFORMED", "ERROR", "The count does not fit")
  expert_field("truncated", "sertap.truncated", "MALFORMED", "ERROR", "The record is cut")
  expert_field("error_character", "sertap.error.character.expert", "CHECKSUM", "WARN",
    "Parity or framing error on the line")
  expert_field("error_break", "sertap.error.break.expert", "PROTOCOL", "WARN", "Break on the line")
  expert_field("error_lost", "sertap.error.lost.expert", "SEQUENCE", "WARN",
    "Characters were lost before the tap could read them")
  expert_field("error_unlocated", "sertap.error.unlocated.expert", "CHECKSUM", "WARN",
    "A line error, the adapter does not say at which character")
  expert_field("event", "sertap.event.expert", "SEQUENCE", "WARN", "The capture has a gap")

  -- What a flag is called at its character, and, for an error, what is said of the record that has it, with the number
  -- of the first character that has it.
  local flags = {
    {flag = K.SAME_READ, field = FT.same_read, text = "same read"},
    {flag = K.CHARACTER_ERROR, field = FT.error_character, text = "parity or framing error",
      expert = ET.error_character, mark = "parity or framing error at character %d"},
    {flag = K.BREAK, field = FT.error_break, text = "break", expert = ET.error_break, mark = "break at character %d"},
    {flag = K.LOST_BEFORE, field = FT.error_lost, text = "characters lost before it", expert = ET.error_lost,
      mark = "the tap lost characters before character %d"},
    {flag = K.UNLOCATED_ERROR, field = FT.error_unlocated, text = "error somewhere in this read",
      expert = ET.error_unlocated, mark = "line error, place unknown"},
    {flag = K.INTERVAL_UNKNOWN, field = FT.interval_unknown, text = "interval unknown"},
    {flag = K.INTERVAL_SATURATED, field = FT.interval_saturated, text = "interval longer than it can be stored"},
  }

  local framing_table = DissectorTable.new("sertap.framing", "Serial framing", ftypes.UINT8, base.DEC, sertap)
  local current -- the record that is being dissected
  local handle -- of this dissector, once there is one

  -- The record that this packet is; nil where it is none.
  function T.record()
    return current
  end

  -- The first of the record's characters, from 0, that `part`, cut out of its payload, has.
  function T.index(record, part)
    return part:offset() - record.raw_offset - record.data_offset
  end

  -- ns of one character, start and stop bits included; 0 where the rate is not known.
  function T.character_ns(record)
    local half_bits = 2 + 2 * record.data_bits + (record.parity ~= 0 and 2 or 0) + record.stop_half_bits

    return record.baud ~= 0 and floor(half_bits * 500000000 / record.baud) or 0
  end

  -- ns since the character before; characters count from 0.
  function T.interval_of(record, character)
    return record.intervals[character + 1]
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
    local parity, stop = parity_letters[record.parity] or "?", stop_bits[record.stop_half_bits] or "?"
    local subtree = add(tree, FT.format, tvb, 8, 3, strformat("%d%s%s", record.data_bits, parity, stop))

    add(subtree, FT.data_bits, tvb, 8, 1)
    add(subtree, FT.parity, tvb, 9, 1)
    add(subtree, FT.stop_bits, tvb, 10, 1)
  end

  -- Unknown has no value: a filter for bad times would find it.
  local function add_uncertainty(tree, tvb, uncertainty)
    if uncertainty then
      add_value(tree, FT.uncertainty, tvb, 12, 4, nstime(uncertainty), strformat("%.3f ms", uncertainty / 1e6))
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

  -- Whether version and length of the header can be read; says why not. The second result tells whether that is because
  -- the capture has cut the packet.
  local function check_header(tvb, tree, root, bytes, there)
    local version, size = byte(bytes, 1, 2)

    if not version then
      if there == 0 then add_expert(root, ET.truncated) end
      return false, there > 0
    end
    local item = add(tree, FT.version, tvb, 0, 1) or root
    if version ~= RECORD_VERSION then
      add_expert(item, ET.version,
        strformat("Record version %d is not known here, only %d", version, RECORD_VERSION))
      return false
    end
    if there < RECORD_HEADER_SIZE then
      add_expert(item, ET.truncated)
      return false
    end
    if not size then return false, true end
    item = add(tree, FT.header_length, tvb, 1, 1) or root
    if size < RECORD_HEADER_SIZE or there < size then
      add_expert(item, size < RECORD_HEADER_SIZE and ET.header_length or ET.truncated)
      return false
    end
    return #bytes >= RECORD_HEADER_SIZE, #bytes < RECORD_HEADER_SIZE
  end

  -- The record that is dissected: one table for all of them, as making new ones would cost more than all the rest.
  local reused = {}

  -- Reads a record whose header can be read. What is whole is decoded, also where something is missing.
  local function read_record(tvb, bytes)
    local record, _, size, kind, uncertainty, declared = reused
    _, size, kind, record.line, record.baud, record.data_bits, record.parity, record.stop_half_bits, record.framing,
      uncertainty, declared, record.event = Struct.unpack(">BBBBI4BBBBI4I2I2", bytes)
    local captured = max(#bytes - size, 0)

    record.bytes = bytes
    record.raw_offset = tvb:offset()
    record.type = kind
    record.uncertainty = uncertainty ~= UNCERTAINTY_UNKNOWN and uncertainty or nil -- ns
    record.declared = declared -- characters the record says it has
    record.count = min(captured, declared) -- characters whose value is there
    -- Characters whose interval and flags are there, too. The three arrays follow one another: what is missing at the
    -- end is missing from the flags first.
    record.timed = kind ~= K.EVENT and max(min(captured - declared * 5, declared), 0) or 0
    record.data_offset = size -- of the values
    record.times_offset = size + declared -- of the intervals, 4 bytes each, ns
    record.flags_offset = size + declared * 5
    record.known = nil -- in the first pass: what is known of the line
    record.flags = 0 -- of all its characters, ORed
    record.first_at = nil -- by flag: the first character that has it
    record.intervals = nil -- ns
    record.duration = 0 -- ns, from the first character to the last
    record.interval_max = 0 -- ns, longest between two characters of this record
    record.interval_max_at = 0 -- before this character; 0: there is none
    return record
  end

  -- Compares the count with the bytes that are there.
  local function check_count(item, record, there)
    local declared, rest = record.declared, there - record.data_offset
    local expected = declared * (record.type == K.EVENT and 1 or 6)

    if rest < expected then
      add_expert(item, ET.truncated, strformat("The record is cut: %d bytes of %d after its header", rest, expected))
    elseif rest > expected then
      add_expert(item, ET.count,
        strformat("The count does not fit: %d bytes after its %d characters", rest - expected, declared))
    end
  end

  local CHUNK = 64 -- so many intervals in one call: it has all of them on Lua's stack
  local interval_formats = {}

  for count = 0, CHUNK do
    interval_formats[count] = ">" .. rep("I4", count)
  end

  local function read_intervals(bytes, offset, count)
    if count == 0 then return {} end -- the record may end before them
    local intervals = {Struct.unpack(interval_formats[min(count, CHUNK)], bytes, offset + 1)}

    for done = CHUNK, count - 1, CHUNK do
      local more = {Struct.unpack(interval_formats[min(count - done, CHUNK)], bytes, offset + 4 * done + 1)}

      for i = 1, min(count - done, CHUNK) do
        intervals[done + i] = more[i]
      end
    end
    return intervals
  end

  -- The flags of all characters together, and which character was the first with each of them.
  local function survey_flags(record)
    local bytes, offset = record.bytes, record.flags_offset
    local at = string.find(bytes, "[^\0]", offset + 1)

    if at then record.first_at = {} end
    while at and at <= offset + record.timed do
      local flag = byte(bytes, at)

      for bit_value = 0, 7 do
        local one = lshift(1, bit_value)

        if band(flag, one) ~= 0 and not record.first_at[one] then record.first_at[one] = at - offset - 1 end
      end
      record.flags = bit.bor(record.flags, flag)
      at = string.find(bytes, "[^\0]", at + 1)
    end
  end

  -- Longest interval and errors. The interval before the first character is not one of this record, and what happened
  -- before a character that follows lost ones nobody knows.
  local function survey_characters(record)
    local timed = record.timed
    local intervals = read_intervals(record.bytes, record.times_offset, timed)
    local duration, longest, longest_at = 0, 0, 0

    survey_flags(record)
    local may_be_lost = band(record.flags, K.LOST_BEFORE) ~= 0
    for i = 2, timed do
      local interval = intervals[i]

      duration = duration + interval
      if interval > longest
        and not (may_be_lost and band(T.flags_of(record, i - 1), K.LOST_BEFORE) ~= 0) then
        longest, longest_at = interval, i - 1
      end
    end
    record.intervals = intervals
    record.duration, record.interval_max, record.interval_max_at = duration, longest, longest_at
  end

  local function interval_text(interval, flag)
    return strformat("%s%.3f ms", band(flag, K.INTERVAL_SATURATED) ~= 0 and "more than " or "", interval / 1e6)
  end

  local function add_character(tree, tvb, record, index)
    local data_at, time_at = record.data_offset + index, record.times_offset + 4 * index
    local flags_at = record.flags_offset + index
    local value, flag = byte(record.bytes, data_at + 1), T.flags_of(record, index)
    local interval = record.intervals[index + 1]
    local subtree = add(tree, FT.character, tvb, data_at, 1, value,
      strformat("Character %d: 0x%02x", index + 1, value))

    if band(flag, K.INTERVAL_UNKNOWN) == 0 then
      local text = interval_text(interval, flag)

      append_text(subtree, ", after " .. text)
      add_value(subtree, FT.interval, tvb, time_at, 4, nstime(interval), text)
    end
    add(subtree, FT.flags, tvb, flags_at, 1)
    for _, known in ipairs(flags) do
      if band(flag, known.flag) ~= 0 then
        append_text(subtree, ", " .. known.text)
        add(subtree, known.field, tvb, flags_at, 1)
      end
    end
  end

  local function add_interval_max(tree, tvb, record)
    local at, longest = record.interval_max_at, record.interval_max
    local text = interval_text(longest, T.flags_of(record, at))
    local item = add_value(tree, FT.interval_max, tvb, record.times_offset + 4 * at, 4, nstime(longest),
      strformat("%s, before character %d", text, at + 1))

    set_generated(item)
    if record.uncertainty then
      append_text(item, strformat(" (times uncertain by %.3f ms)", record.uncertainty / 1e6))
    end
  end

  -- Whether somebody sees the characters or filters for them. Most readings of a large file do neither, and a record
  -- has five items a character.
  local function are_characters_wanted(tree)
    if tree:referenced(FT.character) or tree:referenced(FT.interval) or tree:referenced(FT.flags) then return true end
    for _, known in ipairs(flags) do
      if tree:referenced(known.field) then return true end
    end
    return false
  end

  local function add_characters(tree, tvb, record)
    local length = record.flags_offset + record.timed - record.data_offset

    if record.interval_max_at > 0 then add_interval_max(tree, tvb, record) end
    if not are_characters_wanted(tree) then return end
    local subtree = add_subtree(tree, tvb, record.data_offset, length,
      strformat("%d character%s", record.timed, plural(record.timed)))
    for index = 0, record.timed - 1 do
      add_character(subtree, tvb, record, index)
    end
  end

  -- One item and one mark a kind of error, however many characters have it.
  local function report_errors(pinfo, item, record)
    for _, known in ipairs(flags) do
      if known.expert and band(record.flags, known.flag) ~= 0 then
        local text = strformat(known.mark, record.first_at[known.flag] + 1)

        add_expert(item, known.expert, text)
        pinfo.cols.info:append("  [" .. text .. "]")
      end
    end
  end

  local escapes = {["\a"] = "\\a", ["\b"] = "\\b", ["\f"] = "\\f", ["\n"] = "\\n", ["\r"] = "\\r", ["\t"] = "\\t",
    ["\v"] = "\\v"}

  -- What follows the byte `lead`, which begins no ASCII character, as far as it is UTF-8.
  local function format_beyond_ascii(lead, rest)
    local length = lead < "\192" and 0 or lead < "\224" and 1 or lead < "\240" and 2 or lead < "\248" and 3 or 0
    local taken = sub(rest, 1, length)

    return (length > 0 and #taken == length and lead .. taken or "\239\191\189")
      .. rep("\239\191\189", #rest - #taken)
  end

  -- As tvb_format_text() does it: in quotes, it would read like a string of C.
  local function format_text(text)
    text = string.gsub(text, "%c", function(c)
      return escapes[c] or strformat("\\%03o", byte(c))
    end)
    return (string.gsub(text, "([\128-\255])([\128-\191]*)", format_beyond_ascii))
  end

  local function dissect_event(tvb, pinfo, tree, root, record)
    local name = events[record.event] or "Event of a later version"
    local offset, count = record.data_offset, record.count
    local text = name .. ": " .. format_text(sub(record.bytes, offset + 1, offset + count))
    local item = add(tree, FT.event, tvb, 18, 2) or root

    if tree then tree:add_packet_field(FT.text, tvb(offset, count), ENC_UTF_8) end
    if record.event == K.CHARACTERS_LOST or record.event == K.ADAPTER_LOST then
      add_expert(item, ET.event, text)
    end
    write_columns(pinfo, text)
  end

  -- Whether a person would read this rather than decode it.
  local function is_text(bytes)
    local _, readable = string.gsub(bytes, "[\t-\r -~]", "")

    return readable * 4 >= #bytes * 3
  end

  -- As hex and as text: a drive talks ASCII until SIS is selected.
  local function dissect_other(tvb, pinfo, tree, record)
    local offset, count = record.data_offset, record.count
    local shown = sub(record.bytes, offset + 1, offset + min(count, 24))
    local more = #shown < count and " ..." or ""
    local info = strformat("%d other character%s", count, plural(count))

    if count > 0 then
      add(tree, FT.data, tvb, offset, count)
      add(tree, FT.text, tvb, offset, count)
      info = info .. "  " .. hex(shown) .. more
      if is_text(shown) then info = info .. "  \"" .. format_text(shown) .. "\"" .. more end
    end
    write_columns(pinfo, info)
  end

  -- The columns are for a dissector that finds that this is not its frame. SIS writes both of them.
  local function dissect_frame(tvb, pinfo, parent, record)
    local count = record.count

    if record.framing ~= FRAMING_SIS or count == 0 then
      write_columns(pinfo, strformat("%d character%s", count, plural(count)))
    end
    if count > 0 then framing_table:try(record.framing, tvb(record.data_offset, count):tvb(), pinfo, parent) end
  end

  local function dissect_characters(tvb, pinfo, parent, tree, root, record)
    if tree and record.timed > 0 then add_characters(tree, tvb, record) end
    if record.type == K.FRAME then
      current = record
      dissect_frame(tvb, pinfo, parent, record)
      current = nil
    else
      dissect_other(tvb, pinfo, tree, record)
    end
    if record.flags ~= 0 then report_errors(pinfo, root, record) end -- after the info column has its text
  end

  local function dissect_record(tvb, pinfo, parent, tree, root, record)
    if tree then show_header(tvb, tree, record) end
    check_count(add(tree, FT.count, tvb, 16, 2) or root, record, tvb:reported_len())
    append_text(tree, ", " .. (types[record.type] or "type of a later version"))
    if record.type ~= K.EVENT then survey_characters(record) end
    if not pinfo.visited then T.line_note(pinfo, record) end
    if record.type == K.EVENT then
      dissect_event(tvb, pinfo, tree, root, record)
    else
      dissect_characters(tvb, pinfo, parent, tree, root, record)
    end
  end

  function sertap.dissector(tvb, pinfo, parent)
    local bytes, there = tvb:raw(), tvb:reported_len()
    local tree = (#bytes > 0 or there == 0) and parent:referenced(handle) and parent:add(sertap, tvb()) or nil
    local root = tree or parent
    local can_be_read, is_cut = check_header(tvb, tree, root, bytes, there)

    if can_be_read then
      dissect_record(tvb, pinfo, parent, tree, root, read_record(tvb, bytes))
    elseif is_cut then
      write_columns(pinfo, "")
      S.show_cut(tvb, pinfo, parent, "SERTAP")
    else
      write_columns(pinfo, "Record that cannot be read")
    end
  end

  handle = sertap.dissector
end
