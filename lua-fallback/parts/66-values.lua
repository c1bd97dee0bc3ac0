
-- values (sis-values.c): the elements of a parameter: attribute bit by bit, values scaled and with their unit, lists
-- element by element. SIS says nothing of all this; it is SERCOS, IEC 61491.

do
  local ATTRIBUTE_SIZE = 4
  local LIST_HEADER = 4 -- actual and maximum length, two bytes each

  local lengths = {
    [0] = "Not defined",
    "2 bytes",
    "4 bytes",
    "8 bytes",
    "List of single bytes",
    "List of 2-byte elements",
    "List of 4-byte elements",
    "List of 8-byte elements",
  }
  local sizes = {[0] = 0, 2, 4, 8, 1, 2, 4, 8} -- by the same code

  local formats = {
    [0] = "Binary",
    "Unsigned decimal",
    "Signed decimal",
    "Hexadecimal",
    "Text",
    "Ident number",
    "Floating point",
    "Not defined",
  }
  local BINARY, UNSIGNED, SIGNED, HEXADECIMAL, TEXT, IDENT, FLOATING = 0, 1, 2, 3, 4, 5, 6

  local requests = {[0] = "clear", [1] = "interrupt", [3] = "set and enable"}

  field("value", "Value", "sis.value", ftypes.STRING, nil, nil, 0, "Scaled, with its unit where that is known")
  field("element_name", "Name", "sis.element.name", ftypes.STRING)
  field("element_unit", "Unit", "sis.element.unit", ftypes.STRING)
  field("attribute", "Attribute", "sis.attribute", ftypes.UINT32, base.HEX)
  field("attribute_factor", "Conversion factor", "sis.attribute.factor", ftypes.UINT32, base.DEC, nil, 0x0000FFFF)
  field("attribute_length", "Length", "sis.attribute.length", ftypes.UINT32, base.DEC, lengths, 0x00070000)
  field("attribute_command", "Procedure command", "sis.attribute.command", ftypes.BOOLEAN, 32, nil, 0x00080000)
  field("attribute_format", "Format", "sis.attribute.format", ftypes.UINT32, base.DEC, formats, 0x00700000)
  field("attribute_decimals", "Decimal places", "sis.attribute.decimals", ftypes.UINT32, base.DEC, nil, 0x0F000000)
  field("protected_2", "Write-protected in phase 2", "sis.attribute.protected_2", ftypes.BOOLEAN, 32, nil, 0x10000000)
  field("protected_3", "Write-protected in phase 3", "sis.attribute.protected_3", ftypes.BOOLEAN, 32, nil, 0x20000000)
  field("protected_4", "Write-protected in phase 4", "sis.attribute.protected_4", ftypes.BOOLEAN, 32, nil, 0x40000000)
  field("list_actual", "Actual length of the list", "sis.list.actual", ftypes.UINT16, base.DEC, nil, 0, "In bytes")
  field("list_maximum", "Maximum length of the list", "sis.list.maximum", ftypes.UINT16, base.DEC, nil, 0, "In bytes")

  -- `size` bits of a number from bit `first` on; `bit` of Lua is signed.
  local function bits(number, first, size)
    return floor(number / 2 ^ first) % 2 ^ size
  end

  -- How the elements of some data are read, made from an attribute; nil for the length codes that are not defined. The
  -- unit is nil where it is none or unknown.
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

  -- With a point in every locale: people filter for it.
  local function double_text(digits, value)
    return (string.gsub(strformat("%." .. digits .. "g", value), ",", "."))
  end

  -- Digits of a whole number with a point before the last ones.
  local function point_text(digits, decimals)
    digits = rep("0", decimals + 1 - #digits) .. digits
    return decimals == 0 and digits or sub(digits, 1, -decimals - 1) .. "." .. sub(digits, -decimals)
  end

  -- Fixed point: exact, as the decimal places say. `magnitude` is a number, or an UInt64 for 8 bytes.
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

  -- A whole number of 8 bytes, and what makes 0 together with it.
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

  -- By format: how a number is written, and how many bytes that needs; without its unit.
  local writers = {
    [BINARY] = {write = binary_text, least = 1, most = 8},
    [UNSIGNED] = {write = unsigned_text, least = 1, most = 8},
    [SIGNED] = {write = signed_text, least = 1, most = 8},
    [IDENT] = {
      write = function(bytes, at)
        return S.ident(0, S.little_endian(bytes, at, 2)).text
      end,
      least = 2,
      most = 2,
    },
    [FLOATING] = {write = float_text, least = 4, most = 8},
  }

  local function number_text(bytes, at, layout)
    local writer = writers[layout.format]

    if writer and layout.size >= writer.least and layout.size <= writer.most then
      return writer.write(bytes, at, layout)
    end
    return hexadecimal_text(bytes, at, layout)
  end

  -- Of the value at `at`, which counts from 1.
  local function value_text(bytes, at, layout)
    local number, format, unit = number_text(bytes, at, layout), layout.format, layout.unit
    local request = layout.is_command and requests[S.little_endian(bytes, at, min(layout.size, 4))]

    if request then return number .. " (" .. request .. ")" end
    if not unit or unit == "" or format == BINARY or format == IDENT or format == HEXADECIMAL then return number end
    return number .. " " .. unit
  end

  -- The two length words of a SERCOS list, where they are really there: it is not certain that SIS carries them.
  local function list_header_size(data)
    if data.length < LIST_HEADER then return 0 end
    local actual, maximum = S.little_endian(data.bytes, 1, 2), S.little_endian(data.bytes, 3, 2)

    return actual + LIST_HEADER == data.length and actual <= maximum and LIST_HEADER or 0
  end

  -- A name or a unit, without the two length words that a list may begin with.
  function S.element_text(data)
    return S.text(sub(data.bytes, list_header_size(data) + 1))
  end

  -- Gives the size of the length words, 0 if there are none.
  local function add_list_header(tree, data, is_whole)
    local size = is_whole and list_header_size(data) or 0

    if size > 0 then
      add_le(tree, F.list_actual, data.tvb, data.offset, 2)
      add_le(tree, F.list_maximum, data.tvb, data.offset + 2, 2)
    end
    return size
  end

  local function add_text(tree, which, data, is_whole)
    local header = add_list_header(tree, data, is_whole)
    local text = S.text(sub(data.bytes, header + 1))

    add(tree, which, data.tvb, data.offset + header, data.length - header, text)
    return '"' .. text .. '"'
  end

  -- From the highest bit to the lowest; what is said of those that are set, or of all where there are words, stands
  -- beside the attribute, too.
  local attribute_bits = {
    {field = F.protected_4, first = 30, words = {[1] = "Write-protected in phase 4"}},
    {field = F.protected_3, first = 29, words = {[1] = "Write-protected in phase 3"}},
    {field = F.protected_2, first = 28, words = {[1] = "Write-protected in phase 2"}},
    {field = F.attribute_decimals},
    {field = F.attribute_format, first = 20, size = 3, name = "Format: ", words = formats},
    {field = F.attribute_command, first = 19, words = {[1] = "Procedure command"}},
    {field = F.attribute_length, first = 16, size = 3, name = "Length: ", words = lengths},
    {field = F.attribute_factor},
  }

  local function show_attribute(tree, data, attribute)
    local item = add_le(tree, F.attribute, data.tvb, data.offset, ATTRIBUTE_SIZE)

    for _, part in ipairs(attribute_bits) do
      local word = part.words and part.words[bits(attribute, part.first, part.size or 1)]

      add_le(item, part.field, data.tvb, data.offset, ATTRIBUTE_SIZE)
      if word then append_text(item, ", " .. (part.name or "") .. word) end
    end
  end

  local function add_attribute(tree, data)
    if data.length ~= ATTRIBUTE_SIZE then return nil end
    local attribute = S.little_endian(data.bytes, 1, ATTRIBUTE_SIZE)

    if tree then show_attribute(tree, data, attribute) end
    return strformat("0x%08x", attribute)
  end

  local SHOWN_IN_LIST = 4
  local SHOWN_IN_TREE = 100000 -- more than a SERCOS list can have; Wireshark gives up at ten times that

  -- All elements of a list. Which one of its list the first of a segment is cannot be told.
  local function show_list(tree, data, offset, layout, is_whole)
    local size, length = layout.size, data.length - offset
    local count, rest = floor(length / size), length % size
    local subtree = add_subtree(tree, data.tvb, data.offset + offset, length,
      strformat("%d element%s", count, plural(count)))

    for i = 0, min(count, SHOWN_IN_TREE) - 1 do
      local at = offset + i * size
      local value = value_text(data.bytes, at + 1, layout)

      add(subtree, F.value, data.tvb, data.offset + at, size, value,
        is_whole and strformat("Element %d: %s", i + 1, value) or nil)
    end
    if rest > 0 then add(subtree, F.raw, data.tvb, data.offset + data.length - rest, rest) end
  end

  -- All elements into the tree, the first few into the text.
  local function add_list(tree, data, layout, is_whole)
    local offset = add_list_header(tree, data, is_whole)
    local count, values = floor((data.length - offset) / layout.size), {}

    if tree and tree:referenced(F.value) then show_list(tree, data, offset, layout, is_whole) end
    for i = 1, min(count, SHOWN_IN_LIST) do
      values[i] = value_text(data.bytes, offset + (i - 1) * layout.size + 1, layout)
    end
    if count > SHOWN_IN_LIST then values[#values + 1] = strformat("... (%d elements)", count) end
    return count > 0 and concat(values, ", ") or "empty"
  end

  -- Operating data, minimum or maximum; those of a list are as long as one of its elements.
  local function add_value_of(tree, data, element, known, is_whole)
    local layout = known and read_layout(known)

    if not layout then return nil end
    if element ~= K.ELEMENT_DATA and data.length == layout.size then layout.is_list = false end
    if layout.is_list and layout.format == TEXT then return add_text(tree, F.value, data, is_whole) end
    if layout.is_list then return add_list(tree, data, layout, is_whole) end
    if data.length ~= layout.size then return nil end
    local text = value_text(data.bytes, 1, layout)

    add(tree, F.value, data.tvb, data.offset, data.length, text)
    return text
  end

  -- The number word alone does not tell the kind of a control parameter.
  local function add_ident(tree, data, asked)
    if data.length ~= 2 or not asked then return nil end
    local text = S.ident(asked.type, S.little_endian(data.bytes, 1, 2)).text

    add(tree, F.value, data.tvb, data.offset, data.length, text)
    return text
  end

  -- Adds the data of an element: bytes as sis.data, and what they mean as far as that is known. Gives a short text for
  -- the packet list ("12.5000 rpm", "\"Velocity command value\""), nil where there is nothing better than bytes.
  -- `is_whole` is false for a segment of a list; `ident` nil where the command is not known.
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
