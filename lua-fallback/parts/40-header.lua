
-- sis-address: kinds of station addresses in the two editions (fig. 2-9; ECODRIVE03 fig. 1-7)

do
  K.IF02, K.ECODRIVE03 = 0, 1

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

  preference("edition", Pref.enum("Edition of the telegram header", K.IF02,
    "Address ranges, and bits 5 to 7 of the telegram control, differ between editions", {
      {"IF02", "IF02 (SIS definition of 2004, IndraDrive)", K.IF02},
      {"ECODRIVE03", "ECODRIVE03 (FGP-01VRS)", K.ECODRIVE03},
    }, false))

  function S.receiver_kind(receiver)
    return receiver_kinds[P.edition][receiver]
  end

  function S.sender_kind(sender)
    return sender_kinds[P.edition][sender]
  end

  function S.kind_text(kind)
    return N.address_kinds[kind]
  end

  -- Whether a command to this (last) address is answered at all: not by groups and broadcasts.
  function S.is_answered(receiver)
    return S.receiver_kind(receiver) < K.GROUP
  end

  local station_formats = {
    [K.GROUP] = "group %d",
    [K.LEVEL_BROADCAST] = "all on this level",
    [K.GLOBAL_BROADCAST] = "all",
    [K.POINT_TO_POINT] = "point-to-point",
  }
  local station_texts, numbers = {}, {} -- of every address: every telegram asks

  for edition, kinds in pairs(receiver_kinds) do
    station_texts[edition] = {}
    for station, kind in pairs(kinds) do
      station_texts[edition][station] = strformat(station_formats[kind] or "%d", station)
      numbers[station] = strformat("%d", station)
    end
  end

  -- "3", "group 201", "all": as it stands in the info column.
  function S.station_text(station)
    return station_texts[P.edition][station]
  end

  -- Talker and listener as addresses, unless a network below has set its own. Lua has no address type for them, so only
  -- the columns get them. Those of a packet's first telegram count.
  function S.set_addresses(pinfo, talker, listener)
    local packet = S.packet()

    if packet.count > 0 or pinfo.port_type ~= 0 then return end
    packet.cols.src = numbers[talker]
    packet.cols.dst = numbers[listener]
  end
end

-- packet-sis: header and dispatch (DOK-GENERL-SIS-DEFINIT-IF02 chapter 2; "ECODRIVE03": DOK-ECODR3-FGP-01VRS)

do
  K.START = 0x02
  K.STATIC_LENGTH = 8 -- of the header; DatLW counts what comes after it
  -- Telegram control (chapter 2.1).
  K.CONTROL_SUBADDRESSES, K.CONTROL_NUMBER, K.CONTROL_REACTION = 0x07, 0x08, 0x10

  local CONTROL_RESERVED, CONTROL_WARNING, CONTROL_ERROR, CONTROL_STATUS = 0x20, 0x40, 0x80, 0xE0
  local CHECKSUM_BAD, CHECKSUM_GOOD, CHECKSUM_UNVERIFIED = 0, 1, 2

  local checksum_states = {[CHECKSUM_BAD] = "Bad", [CHECKSUM_GOOD] = "Good", [CHECKSUM_UNVERIFIED] = "Unverified"}
  local command_reaction = {"Reaction telegram", "Command telegram"}
  local present_absent = {"Present", "Not present"}

  field("start", "Start character", "sis.start", ftypes.UINT8, base.HEX)
  field("checksum", "Checksum", "sis.checksum", ftypes.UINT8, base.HEX, nil, 0,
    "Makes the sum of all bytes 0 modulo 256")
  field("checksum_status", "Checksum Status", "sis.checksum.status", ftypes.UINT8, base.NONE, checksum_states)
  field("length", "Data length", "sis.length", ftypes.UINT8, base.DEC, nil, 0, "Bytes after the static header of 8")
  field("length_repeat", "Data length repetition", "sis.length_repeat", ftypes.UINT8, base.DEC)
  field("control", "Telegram control", "sis.control", ftypes.UINT8, base.HEX)
  field("control_subaddresses", "Subaddresses", "sis.control.subaddresses", ftypes.UINT8, base.DEC, nil,
    K.CONTROL_SUBADDRESSES)
  field("control_number", "Telegram number", "sis.control.number", ftypes.BOOLEAN, 8, present_absent, K.CONTROL_NUMBER)
  field("control_reaction", "Kind", "sis.control.reaction", ftypes.BOOLEAN, 8, command_reaction, K.CONTROL_REACTION)
  field("control_reserved", "Reserved", "sis.control.reserved", ftypes.BOOLEAN, 8, nil, CONTROL_RESERVED)
  field("control_warning", "System warning of the sender", "sis.control.warning", ftypes.BOOLEAN, 8, nil,
    CONTROL_WARNING)
  field("control_error", "System error of the sender", "sis.control.error", ftypes.BOOLEAN, 8, nil, CONTROL_ERROR)
  field("control_status", "Status", "sis.control.status", ftypes.UINT8, base.DEC, N.control_status_ecodrive03,
    CONTROL_STATUS)
  field("service", "Service", "sis.service", ftypes.UINT8, base.HEX + base.RANGE_STRING, N.services)
  field("sender", "Sender address", "sis.sender", ftypes.UINT8, base.DEC)
  field("receiver", "Receiver address", "sis.receiver", ftypes.UINT8, base.DEC)
  field("subaddress", "Subaddress", "sis.subaddress", ftypes.UINT8, base.DEC)
  field("number", "Telegram number", "sis.number", ftypes.UINT8, base.DEC)
  field("talker", "Talker", "sis.talker", ftypes.UINT8, base.DEC, nil, 0,
    "Who really sends: a reaction keeps the command's addresses")
  field("listener", "Listener", "sis.listener", ftypes.UINT8, base.DEC, nil, 0, "For whom it really is")
  field("station", "Station", "sis.station", ftypes.UINT8, base.DEC, nil, 0, "Talker or listener")

  expert_field("start", "sis.start.missing", "MALFORMED", "ERROR", "No start character 0x02")
  local WRONG_CHECKSUM = "Wrong checksum: a bus does not answer this telegram, "
    .. "a point-to-point station answers with status 0xF4"

  expert_field("checksum", "sis.checksum.bad", "CHECKSUM", "ERROR", WRONG_CHECKSUM)
  expert_field("lengths_differ", "sis.length.differ", "MALFORMED", "ERROR",
    "The two lengths differ: a bus does not answer this telegram, a point-to-point station answers with status 0xF2")
  expert_field("too_short", "sis.length.short", "MALFORMED", "ERROR", "The telegram is cut")
  expert_field("too_long", "sis.length.long", "PROTOCOL", "WARN", "Bytes follow the end of the telegram")
  expert_field("header_too_long", "sis.length.header", "MALFORMED", "ERROR",
    "Subaddresses and telegram number do not fit into the length")
  expert_field("control_reserved", "sis.control.reserved.set", "PROTOCOL", "NOTE",
    "Reserved bits of the telegram control are set (another edition? preference sis.edition)")
  expert_field("control_status", "sis.control.status.set", "RESPONSE_CODE", "NOTE",
    "The status in the telegram control is not 'no error'")
  expert_field("control_error", "sis.control.status.error", "RESPONSE_CODE", "WARN",
    "The status in the telegram control is an error")
  expert_field("system_warning", "sis.control.warning.set", "RESPONSE_CODE", "NOTE",
    "The sender signals a system warning")
  expert_field("system_error", "sis.control.error.set", "RESPONSE_CODE", "WARN", "The sender signals a system error")
  expert_field("service_reserved", "sis.service.reserved", "PROTOCOL", "NOTE", "Reserved service")
  expert_field("sender_service", "sis.sender.service_master", "PROTOCOL", "NOTE",
    "Address 127, for service and emergencies only: not to be used while other masters communicate")
  expert_field("sender_invalid", "sis.sender.invalid", "PROTOCOL", "WARN", "A sender address is not above 127")
  expert_field("receiver_reserved", "sis.receiver.reserved", "PROTOCOL", "WARN",
    "Receiver address that is not assigned or reserved (another edition? preference sis.edition)")
  expert_field("level_broadcast", "sis.receiver.level_broadcast", "PROTOCOL", "WARN",
    "254 may only be the last address of the list")
  expert_field("reaction_unexpected", "sis.reaction.unexpected", "PROTOCOL", "WARN",
    "A group or broadcast is not answered")

  local handle -- of this dissector, once there is one
  local packet = {count = 0, cols = nil} -- what its telegrams share while a packet is dissected

  -- Several telegrams may be in one packet: count of those whose exchange was looked for. The tables that sis-exchange
  -- and others keep are by packet and by this count.
  function S.packet()
    return packet
  end

  -- A TCP segment may come in several calls: only Wireshark's own table of a packet knows that it is still the same.
  function S.begin_packet(pinfo)
    packet.cols = pinfo.cols
    if pinfo.port_type ~= 0 then
      local private = pinfo.private

      if private.sis then return end
      private.sis = "begun"
    end
    packet.count = 0
  end

  -- Something is wrong: an expert item, and a mark that people see in the info column.
  local function mark(body, item, which, text)
    add_expert(item or body.root, which)
    body.marks = body.marks .. "  [" .. text .. "]"
  end

  -- How long the telegram at offset says it is; 0: not told (too short, or its two lengths differ).
  function S.declared_length(bytes, offset)
    local length, length_repeat = byte(bytes, offset + 3, offset + 4)

    return length_repeat and length == length_repeat and K.STATIC_LENGTH + length or 0
  end

  -- Sum of bytes modulo 256; 0 for a telegram with a good checksum.
  function S.sum(bytes, offset, length)
    local sum, last = 0, offset + length

    for at = offset + 1, last, 8 do
      local a, b, c, d, e, f, g, h = byte(bytes, at, min(at + 7, last))

      sum = sum + a + (b or 0) + (c or 0) + (d or 0) + (e or 0) + (f or 0) + (g or 0) + (h or 0)
    end
    return sum % 256
  end

  -- A whole telegram with start character, equal lengths and a zero sum.
  function S.is_good(bytes, offset)
    local declared = S.declared_length(bytes, offset)

    return declared > 0 and offset + declared <= #bytes and byte(bytes, offset + 1) == K.START
      and S.sum(bytes, offset, declared) == 0
  end

  -- Verified only where the whole telegram is there and tells its length.
  local function dissect_checksum(body)
    local telegram, checksum = body.telegram, byte(body.bytes, 2)
    local item = add(body.tree, F.checksum, body.tvb, 1, 1)
    local state = CHECKSUM_UNVERIFIED

    if telegram.sum == 0 then
      state = CHECKSUM_GOOD
    elseif telegram.sum then
      state = CHECKSUM_BAD
    end
    set_generated(add_value(body.tree, F.checksum_status, body.tvb, 1, 0, state, checksum_states[state]))
    if state == CHECKSUM_BAD then
      local expected = strformat("should be 0x%02x", (checksum - telegram.sum) % 256)

      append_text(item, " incorrect, " .. expected)
      add_expert(item or body.root, E.checksum, WRONG_CHECKSUM .. " [" .. expected .. "]")
      body.marks = body.marks .. "  [wrong checksum]"
    else
      append_text(item, state == CHECKSUM_GOOD and " [correct]" or " [unverified]")
    end
  end

  local function dissect_lengths(body)
    local there, declared = body.there, body.declared
    local item = add(body.tree, F.length_repeat, body.tvb, 3, 1)

    if declared == 0 then
      mark(body, item, E.lengths_differ, "lengths differ")
    elseif there < declared then
      add_expert(item or body.root, E.too_short, strformat("The telegram is cut: %d of %d bytes", there, declared))
      body.marks = body.marks .. strformat("  [cut: %d of %d bytes]", there, declared)
    elseif there > declared then
      add_expert(item or body.root, E.too_long,
        strformat("%d bytes follow the end of the telegram", there - declared))
      body.marks = body.marks .. strformat("  [%d bytes too many]", there - declared)
    end
  end

  -- IF02: bit 5 reserved, 6 and 7 the system state of the sender.
  local function dissect_control_if02(body, item)
    local control = body.telegram.control

    if band(control, CONTROL_RESERVED) ~= 0 then mark(body, item, E.control_reserved, "reserved bit") end
    if band(control, CONTROL_WARNING) ~= 0 then mark(body, item, E.system_warning, "system warning") end
    if band(control, CONTROL_ERROR) ~= 0 then mark(body, item, E.system_error, "system error") end
  end

  local ECODRIVE03_ERROR = 6

  -- ECODRIVE03: bits 5 to 7 are the state of a reaction.
  local function dissect_control_ecodrive03(body, item)
    local status = rshift(body.telegram.control, 5)
    local text = N.control_status_ecodrive03[status]

    if status == 0 then return end
    if not body.telegram.is_reaction then
      mark(body, item, E.control_reserved, "reserved bits")
      return
    end
    add_expert(item or body.root, status == ECODRIVE03_ERROR and E.control_error or E.control_status,
      "Status in the telegram control: " .. text)
    body.marks = body.marks .. strformat("  [control status %d: %s]", status, text)
  end

  local bits = {
    [K.IF02] = {F.control_error, F.control_warning, F.control_reserved, F.control_reaction, F.control_number,
      F.control_subaddresses},
    [K.ECODRIVE03] = {F.control_status, F.control_reaction, F.control_number, F.control_subaddresses},
  }

  local function dissect_control(body)
    local item

    if body.tree then
      item = add(body.tree, F.control, body.tvb, 4, 1)
      for _, bit_field in ipairs(bits[P.edition]) do
        add(item, bit_field, body.tvb, 4, 1)
      end
      append_text(item, body.telegram.is_reaction and " (reaction)" or " (command)")
    end
    if body.telegram.control >= CONTROL_RESERVED then
      if P.edition == K.IF02 then dissect_control_if02(body, item) else dissect_control_ecodrive03(body, item) end
    end
  end

  local function dissect_service(body)
    local service = body.telegram.service
    local item = add(body.tree, F.service, body.tvb, 5, 1)

    if S.service_is_reserved(service) or (P.edition == K.ECODRIVE03 and service >= 0xE0) then
      add_expert(item or body.root, E.service_reserved)
    end
  end

  local function dissect_sender(body)
    local sender = body.telegram.sender
    local kind = S.sender_kind(sender)
    local item = body.tree and add_value(body.tree, F.sender, body.tvb, 6, 1, sender,
      strformat("%d (%s)", sender, S.kind_text(kind)))

    if kind == K.SERVICE_MASTER then
      mark(body, item, E.sender_service, "service address 127")
    elseif kind == K.NO_SENDER then
      mark(body, item, E.sender_invalid, "invalid sender address")
    end
  end

  -- What is wrong with one address of the list.
  local function check_receiver(body, item, receiver, kind, is_last)
    if kind == K.NOT_ASSIGNED then mark(body, item, E.receiver_reserved, "address 127 is not assigned") end
    if kind == K.RESERVED then mark(body, item, E.receiver_reserved, "reserved address") end
    if kind == K.LEVEL_BROADCAST and not is_last then
      mark(body, item, E.level_broadcast, "254 before the last address")
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

    if body.tree then
      local text = strformat("%d (%s)", receiver, S.kind_text(kind))

      if which == F.subaddress then
        item = add(body.tree, which, body.tvb, offset, 1, receiver,
          strformat("Subaddress %d: %s", offset - K.STATIC_LENGTH + 1, text))
      else
        item = add_value(body.tree, which, body.tvb, offset, 1, receiver, text)
      end
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
      mark(body, body.root, E.header_too_long, "header longer than telegram")
    end
    if body.tree then
      set_generated(add(body.tree, F.talker, body.tvb, 0, 0, telegram.talker))
      set_generated(add(body.tree, F.listener, body.tvb, 0, 0, telegram.listener))
      set_generated(add(body.tree, F.station, body.tvb, 0, 0, telegram.talker)):set_hidden()
      set_generated(add(body.tree, F.station, body.tvb, 0, 0, telegram.listener)):set_hidden()
    end
  end

  -- The useful data before they are taken apart.
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
    body.is_explained = false
    body.summary = S.service_name(telegram.service)
    body.request = not telegram.is_reaction and {service = telegram.service} or nil
    body.asked = exchange and exchange.request
    body.record = telegram.is_good and record or nil
  end

  -- Takes the useful data apart, with what their exchange knows. Gives words for the packet list.
  local function dissect_useful_data(body)
    local telegram, pinfo = body.telegram, body.pinfo
    local record = S.exchange_find(body.tvb, pinfo, telegram)
    local exchange = record.exchange

    begin_body(body, record)
    S.timing_note(record, telegram, pinfo)
    if telegram.is_good then S.exchange_show(record, telegram, body) end
    S.dissect_body(body)
    if exchange and not telegram.is_reaction then S.exchange_keep(exchange, body.request) end
    S.timing_dissect(telegram, record, body)
    return body.summary
  end

  local function dissect_trailer(body)
    if body.end_ < #body.bytes then add(body.tree, F.raw, body.tvb, body.end_, #body.bytes - body.end_) end
  end

  -- Reads the static header, 8 bytes.
  local function read_header(body)
    local bytes, declared, telegram = body.bytes, body.declared, body.telegram
    local start, _, _, _, control, service, sender, receiver = byte(bytes, 1, K.STATIC_LENGTH)
    local subaddress_count = band(control, K.CONTROL_SUBADDRESSES)
    local has_number = band(control, K.CONTROL_NUMBER) ~= 0
    local is_reaction = band(control, K.CONTROL_REACTION) ~= 0
    local body_offset = K.STATIC_LENGTH + subaddress_count + (has_number and 1 or 0)
    local sum = declared > 0 and #bytes >= declared and S.sum(bytes, 0, declared) or nil
    local is_good = start == K.START and sum == 0 and body_offset <= declared

    telegram.bytes = bytes
    telegram.declared = declared
    telegram.sum = sum -- nil: not all of it is there
    telegram.is_good = is_good
    telegram.control = control
    telegram.service = service
    telegram.sender = sender
    telegram.receiver = receiver
    telegram.subaddress_count = subaddress_count
    telegram.last_address = is_good and byte(bytes, K.STATIC_LENGTH + subaddress_count) or receiver
    telegram.number = is_good and has_number and byte(bytes, body_offset) or 0
    telegram.is_reaction = is_reaction
    telegram.talker = is_reaction and receiver or sender
    telegram.listener = is_reaction and sender or receiver
    telegram.body_offset = body_offset
    telegram.times = S.times(body.tvb, body.pinfo, declared ~= 0 and min(body.there, declared) or body.there)
  end

  -- "3" or, through routers, "3/2/8".
  local function route_text(body)
    local telegram = body.telegram
    local text = S.station_text(telegram.receiver)

    for offset = K.STATIC_LENGTH, min(K.STATIC_LENGTH + telegram.subaddress_count, body.end_) - 1 do
      text = text .. "/" .. S.station_text(byte(body.bytes, offset + 1))
    end
    return text
  end

  -- Who speaks to whom; a reaction keeps the command's addresses.
  local function stations_text(body)
    local telegram = body.telegram

    if telegram.is_reaction then return strformat("%s -> %d", route_text(body), telegram.sender) end
    return strformat("%d -> %s", telegram.sender, route_text(body))
  end

  local function dissect_start(body)
    local item = add(body.tree, F.start, body.tvb, 0, 1)

    if byte(body.bytes, 1) ~= K.START then mark(body, item, E.start, "no start character") end
  end

  local HEAD_LENGTH = 160 -- characters: Wireshark cuts a line of the tree soon after

  local function shortened(words)
    local begins = {} -- of the characters of UTF-8

    if #words <= HEAD_LENGTH then return words end
    for at in string.gmatch(words, "()[^\128-\191]") do
      begins[#begins + 1] = at
    end
    return #begins <= HEAD_LENGTH and words or sub(words, 1, begins[HEAD_LENGTH + 1] - 1) .. "..."
  end

  -- Header and useful data; the packet list says "16 -> 3  Command  Read parameter S-0-0044".
  local function dissect_whole_telegram(body)
    if #body.bytes < K.STATIC_LENGTH then return "" end
    read_header(body)
    S.set_addresses(body.pinfo, body.telegram.talker, body.telegram.listener)
    dissect_start(body)
    dissect_checksum(body)
    add(body.tree, F.length, body.tvb, 2, 1)
    dissect_lengths(body)
    dissect_control(body)
    dissect_service(body)
    dissect_addresses(body)
    local words = dissect_useful_data(body)
    dissect_trailer(body)

    local stations, kind = stations_text(body), body.telegram.is_reaction and "Reaction" or "Command"
    if body.tree then append_text(body.root, strformat(", %s, %s, %s", stations, kind, shortened(words))) end
    return strformat("%s  %s  %s%s", stations, kind, words, body.marks)
  end

  -- Less than the 8 bytes that every telegram has.
  local function dissect_stump(body)
    local there = body.there

    dissect_start(body)
    if #body.bytes == there then
      if there > 1 then add(body.tree, F.raw, body.tvb, 1, there - 1) end
      add_expert(body.root, E.too_short,
        strformat("The telegram is cut: %d byte%s, it has at least %d", there, plural(there), K.STATIC_LENGTH))
    end
    return strformat("Cut telegram, %d of at least %d bytes%s", there, K.STATIC_LENGTH, body.marks)
  end

  -- No start character, and not the length of a telegram either: addresses read from it would be invented.
  local function dissect_no_telegram(body)
    if body.tree then append_text(body.root, ", not a telegram") end
    add_expert(body.root, E.start)
    if #body.bytes == body.there then add(body.tree, F.raw, body.tvb, 0, body.there) end
    return strformat("Not a telegram, %d byte%s", body.there, plural(body.there))
  end

  -- The telegram that is dissected, and its useful data: one table each for all of them, as making new ones would cost
  -- more than what is done with them.
  local body = {telegram = {}}

  -- One telegram; `tvb` begins with it and holds nothing of the next; `there` bytes of it were on the line. Gives the
  -- words for the info column.
  function S.dissect_telegram(tvb, pinfo, parent, there)
    local bytes = tvb:raw()
    local declared = S.declared_length(bytes, 0)
    local tree = parent:referenced(handle) and parent:add(sis, tvb()) or nil

    body.tvb, body.bytes, body.pinfo = tvb, bytes, pinfo
    body.tree, body.root = tree, tree or parent
    body.there, body.declared = there, declared -- 0: its two lengths differ, or are not there
    body.end_ = min(declared > 0 and declared or there, #bytes) -- of what belongs to the telegram and is there
    body.marks = "" -- for the end of the info column: what is wrong
    if byte(bytes, 1) ~= K.START and declared ~= there then return dissect_no_telegram(body) end
    if there < K.STATIC_LENGTH then return dissect_stump(body) end
    return dissect_whole_telegram(body)
  end

  -- Where the telegram at offset ends: at its declared length if another one starts there, else with the data.
  local function telegram_extent(bytes, offset, there)
    local declared = S.declared_length(bytes, offset)

    if declared > 0 and byte(bytes, offset + declared + 1) == K.START then return declared end
    return there - offset
  end

  local function dissect_telegrams(tvb, pinfo, tree)
    local bytes, there, offset = tvb:raw(), tvb:reported_len(), 0

    S.begin_packet(pinfo)
    local cols = packet.cols
    cols.protocol = "SIS"
    while offset < #bytes do
      local extent = telegram_extent(bytes, offset, there)
      local is_alone = offset == 0 and extent == there
      local part = is_alone and tvb or tvb(offset, min(extent, #bytes - offset)):tvb()
      local info = S.dissect_telegram(part, pinfo, tree, extent)

      if offset == 0 then cols.info = info else cols.info:append(" | " .. info) end
      offset = offset + extent
    end
    if #bytes < there then
      if offset == 0 then cols.info = "" end
      S.show_cut(tvb, pinfo, tree, "SIS")
    end
  end

  -- TCP may split telegrams over segments and pack them into one: sis-transports.
  function sis.dissector(tvb, pinfo, tree)
    if pinfo.port_type == K.PORT_TYPE_TCP then return S.dissect_tcp(tvb, pinfo, tree) end
    dissect_telegrams(tvb, pinfo, tree)
  end

  handle = sis.dissector
end
