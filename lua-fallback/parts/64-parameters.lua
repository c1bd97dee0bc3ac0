
-- parameters (sis-parameters.c): how parameters are written, and what the built-in table says of them. What the bus
-- says of them is learned below. Lua has no tables that the user edits.

-- Elements of a parameter, bits 3 to 5 of the parameter control (fig. 8-1).
K.ELEMENT_CHANNEL = 0
K.ELEMENT_IDENT = 1
K.ELEMENT_NAME = 2
K.ELEMENT_ATTRIBUTE = 3
K.ELEMENT_UNIT = 4
K.ELEMENT_MINIMUM = 5
K.ELEMENT_MAXIMUM = 6
K.ELEMENT_DATA = 7

-- Where a name, a unit or an attribute is from, as people read it.
K.FROM_BUS = "learned from the bus"
K.BUILT_IN = "built in"

do
  local BIT_15 = 0x8000
  local SET_SIZE = 0x1000 -- the number word has a number of 12 bits, and a parameter set of 3
  local MAX_SET = 7

  local letters = {[0] = "S", "A", "C"} -- by type, with bit 15 clear

  local types = {S = 0, P = 0, A = 1, C = 2}

  -- Kind, number in set 0, name, and the unit where it is said; from the SIS definition and SYNAX' interface manual.
  local built_in = {
    {"S", 44, "Velocity data scaling type"},
    {"S", 103, "Modulo value"},
    {"P", 12, "C300 Command set absolute measuring"},
    {"P", 40, "Scaling of velocities, analog output channel 1"},
    {"P", 72, "Cam shaft profile"},
    {"A", 4, "Additive position command value", "deg"},
    {"A", 56, "Set-up position 0"},
    {"A", 60, "Fine adjustment"},
    {"C", 1, "Switch-on delay time", "ms"},
    {"C", 29, "Jogging time constant"},
    {"C", 33, "Host communication, control word"},
    {"C", 46, "General diagnostic flag"},
    {"C", 57, "Error number of the serial interface"},
    {"C", 58, "Configuration list of data block 101"},
    {"C", 65, "Configuration list of data block 108"},
    {"C", 66, "Master axis, position feedback value"},
    {"C", 124, "Timeout of the service channel"},
    {"C", 125, "Fieldbus address"},
    {"C", 127, "Fieldbus/Ethernet 1, configuration list of the process input data"},
    {"C", 129, "Fieldbus control bits"},
    {"C", 157, "Data blocks, ident numbers of the configurable S and P parameters"},
    {"C", 193, "PPC, standard gateway"},
    {"C", 194, "PPC, UDP ports"},
  }

  -- "S-0-0044", "P-2-0012", "A-0-0004", "C-0-0066", "type3-0-0066".
  local function ident_text(kind, word)
    local letter = kind == 0 and word >= BIT_15 and "P" or letters[kind] or "type" .. strformat("%d", kind)

    return strformat("%s-%d-%04d", letter, band(rshift(word, 12), MAX_SET), word % SET_SIZE)
  end

  local idents -- by key: the same ident is the same table

  at_init(function() idents = {} end)

  -- Of a type byte and a number word (fig. 8-3).
  local function ident_key(kind, word)
    return kind * 0x10000 + word
  end

  -- An ident: {type, number, key, text: as it is written}.
  function S.ident(kind, word)
    local key = ident_key(kind, word)

    idents[key] = idents[key] or {type = kind, number = word, key = key, text = ident_text(kind, word)}
    return idents[key]
  end

  local by_key = {}

  for _, row in ipairs(built_in) do
    local kind, number, name, unit = unpack(row)

    by_key[ident_key(types[kind], kind == "P" and BIT_15 + number or number)] = {
      name = name,
      name_from = K.BUILT_IN,
      unit = unit,
      unit_from = unit and K.BUILT_IN,
    }
  end

  local nothing = {}

  -- What the built-in table says.
  function S.known_from_tables(ident)
    return by_key[ident.key] or nothing
  end
end

-- learned (sis-learned.c): what the bus itself has said of its parameters. It is learned in the first pass; every
-- command keeps what was known when it was sent, so that all passes show the same.

do
  -- What is known of a parameter: {name, unit, attribute, minimum, maximum}, nil where unknown, each with where it is
  -- from as name_from and so on. Never changed once made: later knowledge makes a new one.

  local DEVICE = 0x1000000 -- above the key of an ident

  -- What the bus has said of a parameter of a device behind a station, which may be behind routers.
  local function look_up(body, ident, device)
    local exchange = body.record and body.record.exchange
    local of_station = exchange and exchange.from.stream.bus.learned[exchange.path]

    return of_station and of_station[device * DEVICE + ident.key]
  end

  -- What is known of a parameter of a device at this telegram: from the bus, else built in.
  function S.learned_known(body, ident, device)
    local learned

    if body.asked then
      learned = body.asked.known
    else
      learned = look_up(body, ident, device)
    end
    if body.request then body.request.known = learned end
    return learned or S.known_from_tables(ident)
  end

  -- What an element says, by element: the field of what is known, and its value, nil where that is none.
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

  -- A good reaction with an element, all of it, and the text that it was shown with (nil: none).
  function S.learn(body, ident, device, element, data, shown)
    local exchange, read = body.record and body.record.exchange, readers[element]

    if body.pinfo.visited or not exchange or not read then return end
    local before = look_up(body, ident, device) or S.known_from_tables(ident)
    local what, value = read(data, shown)
    local source = what .. "_from"

    if value == nil or (before[what] == value and before[source] == K.FROM_BUS) then return end
    local learned, known = exchange.from.stream.bus.learned, {}

    for name, old in pairs(before) do
      known[name] = old
    end
    known[what], known[source] = value, K.FROM_BUS
    learned[exchange.path] = learned[exchange.path] or {}
    learned[exchange.path][device * DEVICE + ident.key] = known
  end
end
