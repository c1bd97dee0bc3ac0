
-- sis-body: the useful data of one service, and what all of the services need (chapters 2.1 and 2.3)

do
  K.LAST_TRANSMISSION = 0x04 -- bit 2 of the parameter control, fig. 8-1

  field("raw", "Not decoded", "sis.raw", ftypes.BYTES)
  field("status", "Status", "sis.status", ftypes.UINT8, base.HEX + base.RANGE_STRING, N.status)
  field("device", "Device address", "sis.device", ftypes.UINT8, base.DEC, nil, 0,
    "Of the device behind the station; its own address, or 0 for the control itself")
  field("subservice", "Subservice", "sis.subservice", ftypes.UINT8, base.HEX)
  field("error", "Error code", "sis.error", ftypes.UINT16, base.HEX, nil, 0,
    "The full code, where a byte is sent together with its subservice")
  field("baud_mask", "Baud rate mask", "sis.baud_mask", ftypes.UINT8, base.HEX)
  field("data", "Data", "sis.data", ftypes.BYTES)
  field("text", "Text", "sis.text", ftypes.STRING, nil, nil, 0, "Useful data of a product group that are plain ASCII")

  expert_field("missing", "sis.body.missing", "PROTOCOL", "WARN", "Useful data are missing")
  expert_field("unexpected", "sis.body.unexpected", "PROTOCOL", "WARN", "More useful data than the service has")
  expert_field("note", "sis.body.note", "PROTOCOL", "NOTE", "Useful data that the documents do not define")
  expert_field("status", "sis.status.execution_error", "RESPONSE_CODE", "NOTE", "The status is an execution error")
  expert_field("status_telegram", "sis.status.telegram_error", "RESPONSE_CODE", "WARN",
    "The status is a telegram error")

  preference("clc_as_sercos", Pref.bool("Decode services 0xC0 to 0xCF like 0x10 to 0x1F", false,
    "The CLC's services are said to be close to the SERCOS services; their layout is not documented"))
  preference("ecodrive_phases", Pref.bool("Decode services 0x82 and 0x8D like 0x12 and 0x1D", false,
    "Reading and switching the phase of an ECODRIVE this way is not confirmed"))

  -- By general service, what takes its body apart: the following blocks fill it.
  S.bodies = {}

  local general_services = {} -- every telegram asks several times

  at_init(function() general_services = {} end)

  local function find_general_service(service)
    local low, group = service % 0x10, service - service % 0x10
    local is_phase, is_parameter = low == 0x2 or low == 0xD, low <= 0x1 or low >= 0xE

    if (group == 0x80 and (is_parameter or (is_phase and P.ecodrive_phases)))
      or (group == 0x90 and (is_parameter or is_phase))
      or (group == 0xC0 and (is_parameter or is_phase) and P.clc_as_sercos) then
      return 0x10 + low
    end
    return service
  end

  -- 0x10 for 0x10, 0x80, 0x90: the general service that a service of a product group is like, else the service itself.
  -- Product groups have services of their own in the layout of 0x1x (chapter 8); those of the CLC are only said to be
  -- close to it, and nobody has seen the phase services of ECODRIVE.
  function S.general_service(service)
    local general = general_services[service]

    if not general then
      general = find_general_service(service)
      general_services[service] = general
    end
    return general
  end

  -- Whether a reaction of this service begins with a status byte. The other product groups need not (chapter 2.1), and
  -- their bodies are not documented.
  local function has_status(service)
    return service <= 0x1F or (service >= 0x80 and service <= 0x9F) or S.general_service(service) ~= service
  end

  -- Whether a body begins with the parameter control and the device address.
  function S.has_control_byte(service)
    local general = S.general_service(service)

    return general == 0x10 or general == 0x11 or general == 0x1E or general == 0x1F
  end

  function S.left(body)
    return body.end_ - body.offset
  end

  -- Words for the packet list.
  function S.say(body, format, ...)
    body.summary = body.summary .. strformat(format, ...)
  end

  -- What is wrong, for the packet list and as an expert item of what was taken last.
  function S.mark(body, which, format, ...)
    local text = strformat(format, ...)

    add_expert(body.item or body.root, which, text)
    body.marks = body.marks .. "  [" .. text .. "]"
  end

  -- Whether so many bytes are left for a field. Saying once that not is enough: after it nothing else can be there
  -- either.
  function S.needs(body, which, size)
    if body.end_ - body.offset >= size and not body.is_short then return true end
    if not body.is_cut and not body.is_short then
      body.item = body.root
      S.mark(body, E.missing, "%s missing", label[which])
    end
    body.is_short = true
    return false
  end

  local function get_value(body, size)
    local a, b, c, d = byte(body.bytes, body.offset + 1, body.offset + size)

    return a + (b or 0) * 0x100 + (c or 0) * 0x10000 + (d or 0) * 0x1000000
  end

  -- Adds `size` bytes, little endian, as a field, and gives their value; body.item is set. Where they are not there:
  -- says so once per body, and nil.
  function S.take(body, which, size)
    if not S.needs(body, which, size) then return nil end

    local value, offset = get_value(body, size), body.offset
    body.item = add_le(body.tree, which, body.tvb, offset, size)
    body.offset = offset + size
    return value
  end

  -- A code as "Text (0x12)", of `size` bytes.
  local function add_code(body, which, size, value, text, digits)
    body.item = body.tree and add_value(body.tree, which, body.tvb, body.offset, size, value,
      strformat("%s (0x%0" .. digits .. "x)", text, value))
    body.offset = body.offset + size
  end

  -- The same for a code whose text depends on the service. Gives value and text.
  function S.take_code(body, which, size, texts)
    if not S.needs(body, which, size) then return nil end

    local value = get_value(body, size)
    local text = texts[value] or "Not defined"
    add_code(body, which, size, value, text, size * 2)
    return value, text
  end

  -- The rest of the body as bytes; false where there is none.
  function S.take_rest(body, which)
    local left = body.end_ - body.offset

    if left == 0 or body.is_short then return false end
    body.item = add(body.tree, which, body.tvb, body.offset, left)
    body.offset = body.end_
    return true
  end

  -- Remembers the device that a command is for.
  function S.request_device(body, device)
    if body.request then
      body.request.has_device = true
      body.request.device = device
    end
  end

  -- Device address and subservice, with which the bodies of 0x00, 0x02 and 0x03 begin. Gives the subservice.
  function S.take_subservice(body, texts)
    local device = S.take(body, F.device, 1)

    if not device then return nil end
    S.request_device(body, device)
    local subservice, text = S.take_code(body, F.subservice, 1, texts)
    if not subservice then return nil end
    if texts[subservice] then
      S.say(body, ": %s", text)
    else
      S.mark(body, E.note, "subservice 0x%02x is not defined", subservice)
    end
    if body.request then body.request.subservice = subservice end
    return subservice
  end

  local function visible_character(c)
    local code = byte(c)

    return code < 0x20 and "\226\144" .. char(0x80 + code) or code == 0x7F and "\226\144\161" or "\239\191\189"
  end

  -- Characters as a person reads them, all of them: control characters as their pictures (U+2400 and following).
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
    body.offset = body.end_
  end

  local baud_bits = {}

  for baud_bit in pairs(N.baud_masks) do
    baud_bits[#baud_bits + 1] = baud_bit
  end
  table.sort(baud_bits)

  -- The rates of a mask, and what of it is not defined.
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
    return concat(rates, ", ")
  end

  -- A mask of baud rates; of several rates only where `several` are allowed. Adds them to the summary. Gives the rate
  -- where it is one, else nil.
  function S.take_baud_mask(body, several)
    local mask = S.take(body, F.baud_mask, 1)

    if not mask then return nil end
    local text = baud_mask_text(mask, several)
    append_text(body.item, " (" .. text .. ")")
    S.say(body, ": %s", text)
    if not several and band(mask, mask - 1) ~= 0 then S.mark(body, E.note, "more than one baud rate") end
    return tonumber(N.baud_masks[mask])
  end

  local function mark_error(body, text, code)
    S.mark(body, E.status, "error 0x%04x: %s", code, text)
    body.is_explained = true
    body.error = code
  end

  -- The error code of the service that stands in place of useful data: two bytes ...
  function S.take_error(body, texts)
    local code, text = S.take_code(body, F.error, 2, texts)

    if code then mark_error(body, text, code) end
  end

  -- ... or one byte, which makes a code with the subservice.
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

  -- After a status that is neither good nor the service's own error: takes what is there; false for those two.
  function S.take_channel_error(body)
    if body.status == 0x02 then
      S.take_error(body, N.errors_channel)
    elseif body.status > 0x02 and body.status < 0xF0 then
      S.take_rest(body, F.raw) -- nobody says what it is
    end
    return body.status >= 0x02
  end

  local function is_phase_service(service)
    local general = S.general_service(service)

    return general == 0x12 or general == 0x1D
  end

  local function take_status(body)
    if not S.needs(body, F.status, 1) then return end

    local status = get_value(body, 1)
    local text = is_phase_service(body.service) and range_text(status, N.status_phase) or range_text(status, N.status)
    body.status = status
    body.status_text = text
    add_code(body, F.status, 1, status, text, 2)
    if status ~= 0 then
      add_expert(body.item or body.root, status < 0xF0 and E.status or E.status_telegram, "Status: " .. text)
    end
  end

  -- Some product groups send ASCII records (chapter 2.1).
  local function is_plain_text(body)
    return string.find(sub(body.bytes, body.offset + 1, body.end_), "^[\t-\r -~]+$") ~= nil
  end

  local function dissect_undocumented(body)
    if body.is_reaction and has_status(body.service) and S.take_channel_error(body) then return end
    S.take_rest(body, F.raw)
  end

  -- What no field has taken: a field that is not there as a whole, or more than the service has.
  local function show_leftover(body)
    local left = body.end_ - body.offset

    if left == 0 then return end
    body.item = add(body.tree, F.raw, body.tvb, body.offset, left)
    if not body.is_short and not body.is_cut then
      S.mark(body, E.unexpected, "%d byte%s more than this service has", left, plural(left))
    end
    body.offset = body.end_
  end

  -- Takes a whole body apart, status byte first; what is left over is marked.
  function S.dissect_body(body)
    local dissect = S.bodies[S.general_service(body.service)]

    if not dissect and body.service >= 0x80 and is_plain_text(body) then
      S.take_text(body, F.text) -- a record of a product group, without a status
      return
    end
    if body.is_reaction and has_status(body.service) then take_status(body) end
    -- After a telegram error not even the useful data header has to be there.
    if not body.is_short and (body.status < 0xF0 or body.end_ > body.offset) then
      (dissect or dissect_undocumented)(body)
    end
    if body.status ~= 0 and not body.is_explained then -- an error code says more
      body.marks = body.marks .. "  [status: " .. body.status_text .. "]"
    end
    show_leftover(body)
    S.sequence_watch(body)
  end
end

-- sis-identification: service 0x00, node identification (chapter 3)

do
  local VERSION_LENGTH = 5 -- "nnVmm"

  field("version", "SIS version", "sis.version", ftypes.STRING)
  field("firmware", "Firmware (FWA) number", "sis.firmware", ftypes.STRING)
  field("type_key", "Device type key", "sis.type_key", ftypes.STRING)

  local function take_version(body)
    local left = S.left(body)

    if left ~= VERSION_LENGTH and not body.is_cut then
      S.mark(body, left < VERSION_LENGTH and E.missing or E.unexpected, "a SIS version has %d characters",
        VERSION_LENGTH)
    end
    S.take_text(body, F.version)
  end

  local data = {
    [0x01] = take_version,
    [0x02] = function(body) S.take_text(body, F.firmware) end,
    [0x03] = function(body) S.take_text(body, F.type_key) end,
    [0x04] = function(body) S.take_baud_mask(body, true) end,
  }

  local function take_raw(body)
    S.take_rest(body, F.raw)
  end

  S.bodies[0x00] = function(body)
    local subservice = S.take_subservice(body, N.subservices_identification)

    if not subservice or not body.is_reaction then return end
    if S.is_ok(body) then
      (data[subservice] or take_raw)(body)
    elseif not S.take_channel_error(body) then
      take_raw(body) -- chapter 3 has no error codes
    end
  end
end

-- sis-cancel: service 0x01, cancel data transmission (chapter 4): address and service may be missing, each or both

do
  field("canceled_service", "Cancelled service", "sis.canceled_service", ftypes.UINT8, base.HEX + base.RANGE_STRING,
    N.services)

  local function take_ambiguous(body)
    if body.request then
      body.request.is_ambiguous = true
      body.request.subservice = byte(body.bytes, body.offset + 1)
    end
    S.take_rest(body, F.raw)
    S.mark(body, E.note, "device address or service, one byte does not tell")
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

  -- The address is repeated if the command had one; how long error data are nobody says.
  local function dissect_reaction(body)
    local had_device = body.asked and body.asked.has_device
    local is_alone = S.left(body) == 1 and body.status == 0 -- there are error data after an error only
    local is_before_code = S.left(body) == 3 and body.status == 0x02

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

-- sis-flash: service 0x02, flash operation (chapter 5)

do
  local READ_FLASH, FIND_HEADER, ERASE_FLASH, BUILD_CHECKSUM = 0x92, 0x93, 0x94, 0x97

  field("address", "Memory address", "sis.address", ftypes.UINT32, base.HEX)
  field("memory_length", "Length", "sis.memory_length", ftypes.UINT32, base.DEC, nil, 0, "In bytes")
  field("target", "Target", "sis.shutdown_target", ftypes.UINT8, base.HEX, N.shutdown_targets)
  field("device_type", "Device type", "sis.device_type", ftypes.UINT8, base.HEX, N.device_types)
  field("crc", "CRC32", "sis.crc32", ftypes.UINT32, base.HEX)

  local function take_address(body)
    local address = S.take(body, F.address, 4)

    if not address then return end
    S.say(body, ", 0x%08x", address)
    if body.request then
      body.request.has_address = true
      body.request.address = address
    end
  end

  local function take_length(body, size)
    local length = S.take(body, F.memory_length, size)

    if length then S.say(body, ", %d byte%s", length, plural(length)) end
  end

  local function take_code(body, which, texts)
    local value, text = S.take_code(body, which, 1, texts)

    if not value then return end
    S.say(body, ", %s", text)
    if not texts[value] then S.mark(body, E.note, "0x%02x is not defined", value) end
  end

  local function take_data(body)
    local length = S.left(body)

    if not S.needs(body, F.data, 1) then return end
    S.take_rest(body, F.data)
    S.say(body, ", %d byte%s", length, plural(length))
  end

  local function take_length_byte(body) take_length(body, 1) end
  local function take_length_word(body) take_length(body, 4) end
  local function take_target(body) take_code(body, F.target, N.shutdown_targets) end
  local function take_device_type(body) take_code(body, F.device_type, N.device_types) end

  -- What stands after the subservice in a command.
  local commands = {
    [0x90] = {take_target, take_address},
    [0x91] = {take_address},
    [0x92] = {take_address, take_length_byte},
    [0x93] = {},
    [0x94] = {take_address, take_length_word},
    [0x96] = {take_address, take_device_type, take_data},
    [0x97] = {take_address, take_length_word},
    [0x9F] = {},
  }

  -- Both numbers 0xFFFFFFFF: everything but loader and kernel.
  local function take_erase_everything(body)
    if S.left(body) < 8 or sub(body.bytes, body.offset + 1, body.offset + 8) ~= rep("\255", 8) then return false end
    S.take(body, F.address, 4)
    S.take(body, F.memory_length, 4)
    S.say(body, ", all but loader and kernel")
    return true
  end

  local function dissect_command(body, subservice)
    local parts = commands[subservice]

    if subservice == ERASE_FLASH and take_erase_everything(body) then return end
    if not parts then
      S.take_rest(body, F.raw)
      return
    end
    for _, take_part in ipairs(parts) do
      take_part(body)
    end
  end

  local function dissect_data(body, subservice)
    if subservice == READ_FLASH then
      take_data(body)
    elseif subservice == FIND_HEADER then
      take_address(body)
    elseif subservice == BUILD_CHECKSUM and S.left(body) >= 4 then -- IndraDrive; IF02 has no data here
      S.say(body, ", 0x%08x", S.take(body, F.crc, 4))
    elseif not N.subservices_flash[subservice] then
      S.take_rest(body, F.raw)
    end
  end

  S.bodies[0x02] = function(body)
    local subservice = S.take_subservice(body, N.subservices_flash)

    if not subservice then return end
    if not body.is_reaction then
      dissect_command(body, subservice)
    elseif S.is_ok(body) then
      dissect_data(body, subservice)
    elseif not S.take_channel_error(body) then
      S.take_error_byte(body, subservice, N.errors_flash)
    end
  end
end

-- sis-initialization: service 0x03, initialization of the SIS communication (chapter 6)

do
  -- Subservices (chapter 6.1).
  K.SET_TRS, K.SET_TZA, K.SET_TMAS, K.SET_BAUD_RATE, K.TEST_BAUD, K.ACCEPT = 0x01, 0x02, 0x03, 0x07, 0x08, 0xFF

  field("time", "Time", "sis.timing.ms", ftypes.UINT16, base.DEC, nil, 0, "In ms")
  field("test_time", "Duration of the test", "sis.test_ms", ftypes.UINT16, base.DEC, nil, 0, "In ms")

  local function take_time(body, which)
    local ms = S.take(body, which, 2)

    if not ms then return nil end
    append_text(body.item, " ms")
    S.say(body, ", %d ms", ms)
    return ms
  end

  local function take_setting(body, request)
    request.setting = take_time(body, F.time)
    return request.setting ~= nil
  end

  local function take_baud_rate(body, request)
    request.setting = S.take_baud_mask(body, false)
    return request.setting ~= nil
  end

  local function take_baud_test(body, request)
    request.test_ms = take_time(body, F.test_time)
    return request.test_ms ~= nil and take_baud_rate(body, request)
  end

  -- By subservice, what takes its data, and tells whether all of what it asks for is there.
  local settings = {
    [K.SET_TRS] = take_setting,
    [K.SET_TZA] = take_setting,
    [K.SET_TMAS] = take_setting,
    [K.SET_BAUD_RATE] = take_baud_rate,
    [K.TEST_BAUD] = take_baud_test,
    [K.ACCEPT] = function() return true end,
  }

  local function take_more(body)
    if S.take_rest(body, F.raw) then
      S.mark(body, E.note, "more data: further subservices? their layout is not defined")
    end
  end

  local function dissect_command(body, subservice)
    local take = settings[subservice]

    if take then body.request.has_setting = take(body, body.request) else S.take_rest(body, F.raw) end
    take_more(body)
  end

  S.bodies[0x03] = function(body)
    local subservice = S.take_subservice(body, N.subservices_initialization)

    if not subservice then return end
    if not body.is_reaction then
      dissect_command(body, subservice)
    elseif S.is_ok(body) then
      take_more(body)
    elseif not S.take_channel_error(body) then
      S.take_error_byte(body, subservice, N.errors_initialization)
    end
    S.bus_learn(body)
  end
end

-- sis-list: service 0x04, execute a list of SIS services (chapter 7): each element is the telegram it stands for

do
  local LIST_SERVICE = 0x04

  field("element_length", "Length", "sis.element_length", ftypes.UINT8, base.DEC, nil, 0,
    "Service and body of this element")

  expert_field("recursion", "sis.list.recursion", "PROTOCOL", "ERROR", "Service 0x04 must not be in its own list")

  local function add_request(list, request)
    local last = list.last_request

    if last then last.next = request else list.request.list = request end
    list.last_request = request
  end

  -- The body of an element, `length` bytes after its service, as if it were alone in a telegram.
  local function dissect_element_body(list, root, service, length, asked)
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
      is_nested = true,
      is_reaction = list.is_reaction,
      service = service,
      status = 0,
      error = 0,
      record = list.record,
      summary = S.service_name(service),
      marks = "",
      asked = asked and asked.service == service and asked or nil,
    }

    if not list.is_reaction then
      element.request = {service = service}
      add_request(list, element.request)
    end
    S.dissect_body(element)
    list.is_explained = list.is_explained or element.is_explained or element.status ~= 0
    local text = element.summary .. element.marks
    append_text(root, ": " .. text)
    S.say(list, "; %s", text)
  end

  local function show_recursion(list, length)
    S.mark(list, E.recursion, "a list in a list")
    if length > 0 then add(list.tree, F.raw, list.tvb, list.offset, length) end
  end

  -- What an element stands for, `length` bytes after its service of which `there` are there.
  local function dissect_element_service(list, number, root, length, there, asked)
    local service = S.take(list, F.service, 1)

    if not service then return end
    if length > there and not list.is_cut then S.mark(list, E.missing, "element %d is cut", number) end
    if service == LIST_SERVICE then
      show_recursion(list, there)
    else
      dissect_element_body(list, root, service, there, asked)
    end
    list.offset = list.offset + there
  end

  -- Length, service, body.
  local function dissect_element(list, number, asked)
    local left, length = S.left(list), byte(list.bytes, list.offset + 1)
    local size, outer = min(length + 1, left), list.tree
    local root = add_subtree(outer, list.tvb, list.offset, size, strformat("Element %d", number))

    list.tree = root
    S.take(list, F.element_length, 1)
    if length == 0 then
      S.mark(list, E.unexpected, "element %d is empty", number)
    else
      dissect_element_service(list, number, root, length - 1, size - 2, asked)
    end
    list.tree = outer
  end

  S.bodies[LIST_SERVICE] = function(body)
    local asked, number = body.asked and body.asked.list, 1

    body.last_request = nil -- of its elements
    if body.is_reaction and S.take_channel_error(body) then return end
    while S.left(body) > 0 and not body.is_short do
      dissect_element(body, number, asked)
      asked = asked and asked.next
      number = number + 1
    end
  end
end

-- sis-sercos: services 0x10, 0x11, 0x12, 0x1D, 0x1E, 0x1F and their twins of the product groups: SERCOS parameters and
-- phases (chapter 8)

do
  local CONTROL_RESERVED = 0xC3

  local last_current = {"last", "current, more follows"}
  local parameter_types = {
    [0] = "Parameter of a drive",
    [1] = "Control parameter, first kind (A)",
    [2] = "Control parameter, second kind (C)",
  }
  local product_standard = {"P, product-specific", "S, standard"}

  field("parameter_control", "Parameter control", "sis.parameter_control", ftypes.UINT8, base.HEX)
  field("parameter_control_reserved", "Reserved", "sis.parameter_control.reserved", ftypes.UINT8, base.HEX, nil,
    CONTROL_RESERVED)
  field("element", "Element", "sis.element", ftypes.UINT8, base.DEC, N.elements, 0x38)
  field("transmission", "Transmission", "sis.transmission", ftypes.BOOLEAN, 8, last_current, K.LAST_TRANSMISSION)
  field("parameter", "Parameter", "sis.parameter", ftypes.STRING)
  field("parameter_name", "Name", "sis.parameter.name", ftypes.STRING)
  field("parameter_unit", "Unit", "sis.parameter.unit", ftypes.STRING)
  field("parameter_minimum", "Minimum", "sis.parameter.minimum", ftypes.STRING)
  field("parameter_maximum", "Maximum", "sis.parameter.maximum", ftypes.STRING)
  field("parameter_type", "Type", "sis.parameter.type", ftypes.UINT8, base.DEC, parameter_types)
  field("parameter_profile", "Kind", "sis.parameter.product_specific", ftypes.BOOLEAN, 16, product_standard, 0x8000)
  field("parameter_set", "Parameter set", "sis.parameter.set", ftypes.UINT16, base.DEC, nil, 0x7000)
  field("parameter_number", "Number", "sis.parameter.number", ftypes.UINT16, base.DEC, nil, 0x0FFF)
  field("list_offset", "List offset", "sis.list_offset", ftypes.UINT16, base.DEC)
  field("list_length", "List length", "sis.list_length", ftypes.UINT16, base.DEC)
  field("data_status", "Data status", "sis.data_status", ftypes.UINT16, base.HEX)
  field("data_status_set", "Command set", "sis.data_status.set", ftypes.BOOLEAN, 16, nil, 0x0001)
  field("data_status_enabled", "Command enabled", "sis.data_status.enabled", ftypes.BOOLEAN, 16, nil, 0x0002)
  field("data_status_not_executed", "Not yet executed", "sis.data_status.not_executed", ftypes.BOOLEAN, 16, nil,
    0x0004)
  field("data_status_impossible", "Execution not possible", "sis.data_status.impossible", ftypes.BOOLEAN, 16, nil,
    0x0008)
  field("data_status_invalid", "Operating data invalid", "sis.data_status.invalid", ftypes.BOOLEAN, 16, nil, 0x0100)
  field("phase", "Phase", "sis.phase", ftypes.UINT8, base.DEC)
  field("switch_in", "Phase switch in", "sis.phase.switch_in", ftypes.FRAMENUM)
  field("switch_time", "Time of the phase switch", "sis.phase.switch_time", ftypes.RELATIVE_TIME, nil, nil, 0,
    "From its command to the poll that ended it")

  -- A body of a parameter service while it is taken apart is an `access`: body, general (service, as a general one),
  -- element, is_last, device, ident (nil: not known; in a reaction its command's), known.

  local function is_segment(access)
    return access.general == 0x11 or access.general == 0x1E
  end

  local function is_write(access)
    return access.general == 0x1E or access.general == 0x1F
  end

  local function show_control(access)
    local body = access.body

    for _, bit_field in ipairs({F.parameter_control_reserved, F.element, F.transmission}) do
      add(body.item, bit_field, body.tvb, body.offset - 1, 1)
    end
    append_text(body.item,
      strformat(" (%s, %s)", N.elements[access.element], access.is_last and "last transmission" or "more follows"))
  end

  local function take_control(access)
    local body = access.body
    local control = S.take(body, F.parameter_control, 1)

    if not control then return false end
    access.element = band(rshift(control, 3), 7)
    access.is_last = band(control, K.LAST_TRANSMISSION) ~= 0
    if body.tree then show_control(access) end
    if band(control, CONTROL_RESERVED) ~= 0 then
      S.mark(body, E.note, "reserved bits of the parameter control")
    end
    access.device = S.take(body, F.device, 1)
    if not access.device then return false end
    if body.request then body.request.element = access.element end
    S.request_device(body, access.device)
    return true
  end

  local function add_generated(tree, tvb, which, text, source)
    if text then append_text(set_generated(add(tree, which, tvb, 0, 0, text)), " (" .. source .. ")") end
  end

  -- What is known of a parameter, and where from.
  local function add_known(access, tree)
    local known, tvb = access.known, access.body.tvb

    if not tree then return end
    add_generated(tree, tvb, F.parameter_name, known.name, known.name_from)
    add_generated(tree, tvb, F.parameter_unit, known.unit, known.unit_from)
    add_generated(tree, tvb, F.parameter_minimum, known.minimum, K.FROM_BUS)
    add_generated(tree, tvb, F.parameter_maximum, known.maximum, K.FROM_BUS)
  end

  -- Which parameter, and which of its elements.
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
    local offset, tvb = body.offset, body.tvb

    body.item = add(body.tree, F.parameter, tvb, offset, 3, access.ident.text)
    if access.known.name then append_text(body.item, " (" .. access.known.name .. ")") end
    add(body.item, F.parameter_type, tvb, offset, 1)
    for _, bit_field in ipairs({F.parameter_profile, F.parameter_set, F.parameter_number}) do
      add_le(body.item, bit_field, tvb, offset + 1, 2)
    end
    add_known(access, body.item)
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
    if body.request then
      body.request.has_ident = true
      body.request.ident = access.ident
    end
    return true
  end

  local function check_announced(body, announced)
    local sent = S.left(body)

    if not body.is_cut and sent > 0 and sent ~= announced then
      S.mark(body, sent < announced and E.missing or E.unexpected, "%d byte%s announced, %d sent", announced,
        plural(announced), sent)
    end
  end

  -- Offset and length count words in ECODRIVE's services, bytes in all others. A reading may ask for any length; what
  -- is written should be as long as it says.
  local function take_segment(access)
    local body = access.body
    local is_words = body.service == 0x81 or body.service == 0x8E
    local unit = is_words and "word" or "byte"
    local offset = S.take(body, F.list_offset, 2)

    if not offset then return false end
    append_text(body.item, " " .. unit .. plural(offset))
    local length = S.take(body, F.list_length, 2)
    if not length then return false end
    append_text(body.item, " " .. unit .. plural(length))
    S.say(body, ", %d %s%s at offset %d", length, unit, plural(length), offset)
    if is_write(access) then check_announced(body, length * (is_words and 2 or 1)) end
    return true
  end

  -- The reaction does not name the parameter: its command did.
  local function recall_parameter(access)
    local body = access.body

    if not body.asked or not body.asked.has_ident then return end
    access.ident = body.asked.ident
    access.known = S.learned_known(body, access.ident, access.device)
    if body.tree then
      local item = set_generated(add(body.tree, F.parameter, body.tvb, 0, 0, access.ident.text))

      if access.known.name then append_text(item, " (" .. access.known.name .. ")") end
      add_known(access, item)
    end
    say_parameter(access)
  end

  local SHOWN_BYTES = 8

  -- The bytes themselves, where they are few.
  local function bytes_text(bytes)
    return #bytes <= SHOWN_BYTES and ": " .. hex(bytes) or ""
  end

  -- The data of an element: all of them, or a segment of a list.
  local function show_data(access, tree, data)
    local body, is_whole = access.body, not is_segment(access)
    local text = S.add_element(tree, body.pinfo, data, access.element, access.ident, access.known, is_whole)

    if is_write(access) and access.element == K.ELEMENT_IDENT then
      return -- the request for the data status repeats its own number
    end
    if text then
      S.say(body, " = %s", text)
    else
      S.say(body, ", %d byte%s%s", data.length, plural(data.length), bytes_text(data.bytes))
    end
    if access.ident and is_whole and body.is_reaction then
      S.learn(body, access.ident, access.device, access.element, data, text)
    end
  end

  local function show_piece(access, whole)
    local body = access.body
    local length = S.left(body)

    S.take_rest(body, F.data)
    S.say(body, ", %s of %d byte%s", access.is_last and "last piece" or "piece", length, plural(length))
    if not whole then return end
    length = whole.length
    show_data(access, add_subtree(body.tree, whole.tvb, whole.offset, length,
      strformat("Data of all pieces, %d byte%s", length, plural(length))), whole)
  end

  -- The data of this telegram, or of all pieces; nil where more of them follow.
  local function find_data(access)
    local body = access.body

    if is_segment(access) or (not access.ident and access.is_last) then return S.data(body) end
    return access.ident
      and S.sequence_data(body, access.ident, access.element, access.device, access.is_last) or nil
  end

  local function take_data(access)
    local body = access.body

    if body.is_short or (S.left(body) == 0
      and not S.is_sequence_open(body, access.ident, access.element, access.device)) then
      return
    end
    local data = find_data(access)
    if not is_segment(access) and (not data or S.is_piece(body)) then
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
      if body.item then add_le(body.item, bit_field, body.tvb, body.offset - 2, 2) end
    end
    local text = strformat("command %s%s", N.data_states[band(status, 0x0F)] or "not defined",
      band(status, 0x0100) ~= 0 and ", operating data invalid" or "")
    append_text(body.item, " (" .. text .. ")")
    S.say(body, " = %s", text)
  end

  -- The upper digit of a code names the element, also where the code is not defined.
  local function take_parameter_error(body)
    S.take_error(body, N.errors_parameter)
    local code = body.error
    local digit = rshift(code, 12)
    if digit >= 1 and digit < 8 and not N.errors_parameter[code] then
      append_text(body.item, ", element: " .. N.elements[digit])
    end
  end

  local function dissect_parameter_command(access)
    local body = access.body

    if not take_control(access) or not take_parameter(access) then return end
    if is_segment(access) and not take_segment(access) then return end
    if not is_write(access) then return end
    if access.element ~= K.ELEMENT_DATA and access.element ~= K.ELEMENT_IDENT then
      S.mark(body, E.note, "only operating data and ident number can be written")
    end
    if S.left(body) == 0 and access.element ~= K.ELEMENT_IDENT then S.needs(body, F.data, 1) end
    take_data(access)
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
    elseif access.element == K.ELEMENT_IDENT or (access.general == 0x1E and S.left(body) == 2) then
      take_data_status(body)
    end
  end

  local function dissect_parameter(body)
    local access = {body = body, general = S.general_service(body.service)}

    if body.is_reaction then dissect_parameter_reaction(access) else dissect_parameter_command(access) end
  end

  local function take_phase(body)
    local phase = S.take(body, F.phase, 1)

    if not phase then return nil end
    local mode = N.phases[phase] and " (" .. N.phases[phase] .. ")" or ""
    append_text(body.item, mode)
    S.say(body, ": phase %d%s", phase, mode)
    return phase
  end

  -- First pass: a switch begins when its command is acknowledged, and ends with the poll that reads its phase or an
  -- error.
  local function follow_switch(body, phase)
    local record, exchange = body.record, body.record.exchange
    local from = exchange.from
    local is_switch = S.general_service(body.service) == 0x1D

    if is_switch and body.status == 0 and body.asked then
      from.phase_switch = {
        command_in = exchange.command_in,
        begin = exchange.command_end,
        to = body.asked.phase or 0,
      }
    elseif not is_switch and from.phase_switch then
      record.phase_switch = from.phase_switch
      record.is_switch_end = body.status ~= 0 or phase == from.phase_switch.to
      if record.is_switch_end then from.phase_switch = nil end
    end
  end

  local function show_switch(body)
    local record = body.record
    local switch = record.phase_switch

    if not switch then return end
    append_text(set_generated(add(body.tree, F.switch_in, body.tvb, 0, 0, switch.command_in)),
      strformat(" (to phase %d)", switch.to))
    if not record.is_switch_end then
      S.say(body, ", switching to phase %d", switch.to)
      return
    end
    local taken = body.telegram.times.begin - switch.begin
    local text = strformat("%.3f s", taken / 1e9)
    set_generated(add_value(body.tree, F.switch_time, body.tvb, 0, 0, nstime(taken), text))
    S.say(body, ", %s after %s", body.status == 0 and "reached" or "failed", text)
  end

  local function dissect_phase_reaction(body)
    local is_accepted = S.general_service(body.service) == 0x1D and body.status == 0
    local phase = 0

    if body.status == 0x01 then
      S.take_rest(body, F.raw) -- described nowhere
      return
    elseif body.status > 0x02 and S.take_channel_error(body) then
      return
    end
    if is_accepted then S.say(body, ", accepted") end -- the documents differ whether the phase of now follows
    if not (is_accepted and S.left(body) == 0) then
      phase = take_phase(body)
      if not phase then return end
    end
    if body.status == 0x02 then S.take_error(body, N.errors_phase) end
    if body.is_nested or not body.record or not body.record.exchange then return end
    if not body.pinfo.visited then follow_switch(body, phase) end
    show_switch(body)
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
