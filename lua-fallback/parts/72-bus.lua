
-- bus (sis-bus.c): what the bus has told about itself, slave by slave and for all (chapter 6). A value counts as told
-- with the slave's good reaction, or at once where nobody answers; subservice 0xFF makes valid what was told.

-- In place of a station's address: what is valid for all.
K.ALL_STATIONS = 255

-- Kinds of settings.
K.TRS, K.TZA, K.TMAS, K.BAUD = 1, 2, 3, 4

do
  -- Subservices (chapter 6.1).
  local TEST_BAUD, ACCEPT = 0x08, 0xFF

  local kinds = {[0x01] = K.TRS, [0x02] = K.TZA, [0x03] = K.TMAS, [0x07] = K.BAUD} -- what the others set

  -- A setting: {value: ms or Bd, set_in: the command, accepted_in: nil where it was not yet}. Settings are by kind, and
  -- never changed once made.

  -- What a bus has told: nothing yet.
  function S.told_new()
    return {
      stations = {}, -- by address, {told, valid}: settings; valid as far as they were accepted for this station
      tests = {}, -- by address: {rate: a setting, finish: ns}: a timed test of a baud rate
      known = {}, -- S.bus_settings() of each station, nil where it is to be made
      is_anything_told = false,
    }
  end

  local function copy(settings)
    local made = {}

    for kind, setting in pairs(settings) do
      made[kind] = setting
    end
    return made
  end

  -- A station that is told something for the first time has so far what is valid for all.
  local function find_station(told, address)
    local all = told.stations[K.ALL_STATIONS]

    if not told.stations[address] then
      told.stations[address] = {told = {}, valid = copy(all and all.valid or {})}
    end
    return told.stations[address]
  end

  local function set_in(setting)
    return setting and setting.set_in or 0
  end

  -- Makes valid for a station what it or all were told, if that is newer. A new rate ends a test.
  local function accept(told, number, frame)
    local station, all = told.stations[number], told.stations[K.ALL_STATIONS]

    for kind = K.TRS, K.BAUD do
      local setting = station.told[kind]

      if set_in(all.told[kind]) > set_in(setting) then setting = all.told[kind] end
      if set_in(setting) > set_in(station.valid[kind]) then
        station.valid[kind] = {value = setting.value, set_in = setting.set_in, accepted_in = frame}
        if kind == K.BAUD then told.tests[number] = nil end
      end
    end
  end

  local function accept_of(told, address, frame)
    find_station(told, K.ALL_STATIONS)
    for number in pairs(told.stations) do
      if address == K.ALL_STATIONS or address == number then accept(told, number, frame) end
    end
  end

  -- `now`: when the telegram ended with which this counts.
  local function learn(told, address, request, command, frame, now)
    local setting, station = {value = request.setting, set_in = command}, find_station(told, address)
    local kind = kinds[request.subservice]

    told.is_anything_told = true
    told.known = {}
    if request.subservice == ACCEPT then accept_of(told, address, frame) end
    if request.subservice == TEST_BAUD then
      told.tests[address] = {rate = setting, finish = now + request.test_ms * 1000000}
    end
    if kind then station.told[kind] = setting end
  end

  local function is_broadcast(kind)
    return kind == K.LEVEL_BROADCAST or kind == K.GLOBAL_BROADCAST
  end

  -- Whether this telegram is what makes a setting count: the good reaction of a station of this line, or a command to
  -- all. Told through a router it is not for a station of this line.
  local function is_told(body, request, is_for_all)
    if not request or not request.has_setting or body.telegram.subaddress_count > 0 then return false end
    if not body.is_reaction then return is_for_all end
    return not is_for_all and body.status == 0 and not body.record.reaction_before
  end

  -- First pass: a command or reaction of service 0x03 whose body has been taken apart. A slave reacts to 0xFF with the
  -- new values already.
  function S.bus_learn(body)
    local telegram, exchange = body.telegram, body.record and body.record.exchange
    local request = body.asked
    local is_for_all = is_broadcast(S.receiver_kind(telegram.receiver))

    if not body.is_reaction then request = body.request end
    if body.pinfo.visited or not exchange or not is_told(body, request, is_for_all) then return end
    local told = exchange.from.stream.bus.told
    local address = is_for_all and K.ALL_STATIONS or byte(exchange.path)

    learn(told, address, request, exchange.command_in, body.pinfo.number, telegram.times.end_)
    if body.is_reaction and request.subservice == ACCEPT then
      body.record.settings = S.bus_settings(told, address, telegram.times.begin)
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

  -- First pass: what is valid for a station, or for all, now (ns); nil where nothing was told.
  function S.bus_settings(told, address, now)
    if not told.is_anything_told then return nil end
    end_test(told, address, now)
    end_test(told, K.ALL_STATIONS, now)
    told.known[address] = told.known[address] or make_settings(told, address)
    return told.known[address]
  end
end
