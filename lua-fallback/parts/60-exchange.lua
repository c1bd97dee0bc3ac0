
-- exchange (sis-exchange.c): what belongs together: command and reaction, repeats (chapter 2.4), and the same exchange
-- on two levels of a hierarchy (chapter 2.2). Found in the first pass, in the order of the capture, and kept for every
-- later one. Frame numbers that are 0 in C are nil here.

do
  field("stream", "Stream", "sis.stream", ftypes.UINT32, base.DEC, nil, nil, "One number for each pair of stations")
  field("reaction_in", "Reaction in", "sis.reaction_in", ftypes.FRAMENUM, base.NONE, frametype.RESPONSE)
  field("command_in", "Command in", "sis.command_in", ftypes.FRAMENUM, base.NONE, frametype.REQUEST)
  field("reaction_time", "Reaction time", "sis.reaction_time", ftypes.RELATIVE_TIME, base.NONE, nil, nil,
    "From the last character of the command to the first of the reaction; from packet to packet where the times of "
      .. "the characters are not known")
  field("repeat_of", "Repeat of", "sis.repeat_of", ftypes.FRAMENUM, base.NONE, frametype.RETRANS_PREV)
  field("gave_up", "Command before, not answered", "sis.unanswered_before", ftypes.FRAMENUM, base.NONE, nil, nil,
    "The master's command before this one, where it went on without a reaction")
  field("routed_from", "Routed from", "sis.routed_from", ftypes.FRAMENUM, base.NONE, nil, nil,
    "The same telegram on the level it came from")

  expert_field("unanswered", "sis.command.unanswered", "SEQUENCE", "NOTE", "No reaction before the next command")
  expert_field("unasked", "sis.reaction.unasked", "SEQUENCE", "NOTE", "The command of this reaction is not known")
  expert_field("answered_before", "sis.reaction.again", "SEQUENCE", "NOTE", "The command was answered before")
  expert_field("repeated", "sis.command.repeat", "SEQUENCE", "NOTE", "The same command again")

  local records -- by place in the packet, then by frame number
  local lines, connections -- by number of the interface, and of TCP
  local stream_count
  local routes -- streams with a command with subaddresses that waits: as keys

  at_init(function()
    records, lines, connections, stream_count, routes = {}, {}, {}, 0, {}
  end)

  local function new_bus(is_connection)
    return {
      is_connection = is_connection,
      damaged_count = 0, -- damaged telegrams, and what may have been one
      damaged_in = 0, -- the last of them
      lost_in = 0, -- the last loss of characters
      last = {}, -- command of each master
      streams = {},
      learned = {},
      told = S.told_new(),
      cycles = {},
    }
  end

  -- A capture has an interface a line. The two directions of a full-duplex tap are two interfaces, one after the other.
  local function line_number(pinfo)
    local record, interface = T.record(), S.interface(pinfo)

    return record and record.line == 2 and interface > 0 and interface - 1 or interface
  end

  -- First pass: the line or connection that a packet belongs to.
  function S.exchange_bus(pinfo)
    local is_connection = pinfo.port_type == K.PORT_TYPE_TCP
    local known = is_connection and connections or lines
    local key = is_connection and S.connection(pinfo) or line_number(pinfo)

    known[key] = known[key] or new_bus(is_connection)
    return known[key]
  end

  local function new_stream(bus)
    local number = stream_count

    stream_count = number + 1
    local stream = {number = number, bus = bus}

    stream.from = {[0] = {stream = stream, transfers = {}}, {stream = stream, transfers = {}}}
    return stream
  end

  -- Two stations, with what lies between them: a drive behind a router is not the router.
  local function find_stream(bus, telegram)
    local sender, receiver = telegram.sender, telegram.receiver
    local key = min(sender, receiver) * 256 + max(sender, receiver)

    if telegram.subaddress_count > 0 then
      key = char(min(sender, receiver), max(sender, receiver)) .. sub(telegram.bytes, 9, 8 + telegram.subaddress_count)
    end
    if not bus.streams[key] then
      bus.streams[key] = new_stream(bus)
    end
    return bus.streams[key]
  end

  -- 0 or 1: in which of the two directions of its stream a telegram's command goes.
  function S.direction(telegram)
    return telegram.sender > telegram.receiver and 1 or 0
  end

  local function note_damaged(bus, number)
    bus.damaged_in = number
    bus.damaged_count = bus.damaged_count + 1
  end

  -- A telegram whose length was damaged is no telegram at all: the tap calls it other characters.
  local function note_disturbance(bus, record)
    local seen = T.disturbance(record)

    bus.lost_in = max(bus.lost_in, seen.lost_in)
    if seen.unframed_in > bus.damaged_in then
      note_damaged(bus, seen.unframed_in)
    end
  end

  -- The same bytes again, where the first had no good reaction; or with the same telegram number, whose reaction the
  -- slave has kept. Another step of a long reading has the same bytes, too, but a reaction in between.
  local function find_repeat(exchange, from, bytes, telegram)
    local before = from.last

    if not before or from.bytes ~= bytes then
      return
    end
    exchange.is_reaction_kept = telegram.number > 0
    exchange.is_kept_reaction_seen = exchange.is_reaction_kept and before.reaction_in ~= nil
    if before.reaction_in and not exchange.is_reaction_kept then
      return
    end
    exchange.repeat_of = before.repeat_of or before.command_in
    exchange.transfer = before.transfer
  end

  -- Neither group nor broadcast: judged by whom it is for in the end.
  local function needs_reaction(exchange)
    return S.is_answered(byte(exchange.path, -1))
  end

  -- A router drops the first address and sends the rest on: is `bytes` what it made of `above`? Addresses of a telegram
  -- are from the sender to the last subaddress: bytes 6 and following.
  local function is_one_level_below(bytes, telegram, above)
    local subaddresses = telegram.subaddress_count
    local number = telegram.body_offset - K.STATIC_LENGTH - subaddresses
    local control = byte(above, 5)

    return #above == #bytes + 1
      and band(control, 0x07) == subaddresses + 1
      and byte(above, 6) == telegram.service
      and (band(control, 0x08) ~= 0) == (number ~= 0)
      and sub(above, 8) == sub(bytes, 7)
  end

  -- Of the commands that wait one level above, the oldest of which this is.
  local function find_route(exchange, bytes, telegram)
    local oldest

    for stream in pairs(routes) do
      for direction = 0, 1 do
        local from = stream.from[direction]
        local above = from.last

        if above and not above.reaction_in and not above.forwarded
          and not (oldest and oldest.command_in < above.command_in)
          and is_one_level_below(bytes, telegram, from.bytes) then
          oldest = above
        end
      end
    end
    if oldest then
      exchange.routed_from = oldest.command_in
      oldest.forwarded = exchange
    end
  end

  -- A master sends its next command: was the one before answered, and how long did it wait (TwM, chapter 10.5)?
  local function follow_command(exchange, before, telegram)
    local from, is_needed = exchange.from, needs_reaction(before)

    if is_needed and not before.reaction_in then
      before.next_command_in = exchange.command_in
      before.is_reaction_damaged = from.stream.bus.damaged_in > before.command_in
      exchange.gave_up = before.command_in
    end
    if exchange.repeat_of then
      exchange.wait = telegram.times.begin - from.last.command_end
    elseif not is_needed then
      exchange.wait = telegram.times.begin - before.command_end
    end
  end

  local function begin_exchange(bus, pinfo, telegram)
    local stream, times = find_stream(bus, telegram), telegram.times
    local from = stream.from[S.direction(telegram)]
    local bytes = sub(telegram.bytes, 1, telegram.declared)
    local exchange = { -- with no more fields than most exchanges need: half of the memory
      from = from,
      path = sub(bytes, 8, 8 + telegram.subaddress_count), -- from the receiver to whom the command is for
      command_in = pinfo.number,
      command_end = times.end_,
      command_end_earliest = times.end_earliest,
      reaction_in = nil,
      reaction_time = nil, -- nil, too, where both are in one packet
      request = nil,
    }
    local before = bus.last[telegram.sender]

    if needs_reaction(exchange) then
      find_repeat(exchange, from, bytes, telegram)
    end
    if next(routes) then
      find_route(exchange, bytes, telegram)
    end
    if before then
      follow_command(exchange, before, telegram)
    end
    bus.last[telegram.sender] = exchange
    from.bytes = bytes
    from.last = exchange
    if telegram.subaddress_count > 0 then
      routes[stream] = true
    end
    return exchange
  end

  -- Parameter control (but its bit 2) and device address of a parameter service, as far as they are there.
  local function is_same_access(command, telegram)
    local body, reaction = telegram.body_offset, telegram.bytes -- in the reaction the status comes first

    if not S.has_control_byte(telegram.service) or body + 2 > #command or body + 3 > telegram.declared then
      return true
    end
    return band(bxor(byte(command, body + 1), byte(reaction, body + 2)), 0xFF - K.LAST_TRANSMISSION) == 0
      and byte(command, body + 2) == byte(reaction, body + 3)
  end

  -- Whether a reaction fits the last command of a direction. A reaction keeps the command's addresses; that a device
  -- swaps sender and receiver cannot be ruled out.
  local function is_reaction_to(command, telegram)
    local control, service, sender, receiver = byte(command, 5, 8)
    local is_kept = sender == telegram.sender and receiver == telegram.receiver
    local is_swapped = sender == telegram.receiver and receiver == telegram.sender
    local layout = K.CONTROL_SUBADDRESSES + K.CONTROL_NUMBER
    local body = telegram.body_offset

    if service ~= telegram.service or band(bxor(control, telegram.control), layout) ~= 0 then
      return false
    end
    if not (is_kept or is_swapped) or sub(command, 9, body) ~= sub(telegram.bytes, 9, body) then
      return false
    end
    return is_same_access(command, telegram)
  end

  -- The master went on, and a damaged telegram came since: a reaction now is that one's, not this command's.
  local function is_given_up(exchange)
    return not exchange.reaction_in
      and exchange.next_command_in
      and exchange.from.stream.bus.damaged_in > exchange.next_command_in
  end

  local function answer(record, exchange, pinfo, telegram)
    local stream = exchange.from.stream

    record.exchange = exchange
    if exchange.reaction_in then
      record.reaction_before = exchange.reaction_in
      return
    end
    exchange.reaction_in = pinfo.number
    if stream.bus.is_connection then
      exchange.next_command_in = nil -- there a master need not wait
    end
    routes[stream] = nil
    if exchange.command_in ~= pinfo.number then
      exchange.reaction_time = telegram.times.begin - exchange.command_end
    end
    if exchange.forwarded then
      record.routed_from = exchange.forwarded.reaction_in
    end
  end

  local function end_exchange(record, bus, pinfo, telegram)
    local stream, kept = find_stream(bus, telegram), S.direction(telegram)

    for i = 0, 1 do
      local from = stream.from[i == 0 and kept or 1 - kept]

      if from.last and not is_given_up(from.last) and is_reaction_to(from.bytes, telegram) then
        answer(record, from.last, pinfo, telegram)
        return
      end
    end
  end

  local function note_telegram(record, pinfo, telegram)
    local bus, tap = S.exchange_bus(pinfo), T.record(pinfo)

    if tap then
      note_disturbance(bus, tap)
    end
    if not telegram.is_good then
      note_damaged(bus, pinfo.number)
    elseif telegram.is_reaction then
      end_exchange(record, bus, pinfo, telegram)
    else
      record.exchange = begin_exchange(bus, pinfo, telegram)
    end
  end

  -- Finds what belongs to a telegram: in the first pass by what is known until now, later as it was found then. Of a
  -- damaged telegram, the reaction that a command waits for may have been this one. Never nil.
  function S.exchange_find(_, pinfo, telegram)
    local packet, number = S.packet(pinfo), pinfo.number
    local place = packet.count + 1 -- several telegrams may be in one packet
    local kind = telegram.service + (telegram.is_reaction and 0x100 or 0)

    packet.count = place
    records[place] = records[place] or {}
    local record = records[place][number]

    if record and record.kind == kind then return record end
    -- A telegram that the first pass did not see: TCP put its segments together in another way.
    if record or pinfo.visited then return {kind = kind} end
    record = {
      kind = kind, -- to know the telegram again
      exchange = nil, -- of a damaged telegram, and of a reaction without a command
      busy = nil,
      span = nil,
    }
    records[place][number] = record
    note_telegram(record, pinfo, telegram)
    return record
  end

  -- Keeps what a command asks for, once.
  function S.exchange_keep(exchange, request)
    exchange.request = exchange.request or request
  end

  local function add_frame(tree, tvb, which, frame)
    if frame then
      set_generated(add(tree, which, tvb, 0, 0, frame))
    end
  end

  local function show_command(exchange, body)
    local tree, tvb, root = body.tree, body.tvb, body.root

    add_frame(tree, tvb, F.reaction_in, exchange.reaction_in)
    add_frame(tree, tvb, F.repeat_of, exchange.repeat_of)
    add_frame(tree, tvb, F.gave_up, exchange.gave_up)
    add_frame(tree, tvb, F.routed_from, exchange.routed_from)
    if exchange.repeat_of then
      add_expert(root, E.repeated, strformat("The command of frame %d again", exchange.repeat_of))
      body.marks = body.marks .. "  [repeat]"
    end
    if exchange.next_command_in then
      add_expert(root, E.unanswered, strformat("No reaction before the next command (frame %d)%s",
        exchange.next_command_in, exchange.is_reaction_damaged and "; a damaged telegram came between" or ""))
    end
  end

  local function show_reaction(record, body)
    local exchange = record.exchange
    local tree, tvb, root = body.tree, body.tvb, body.root

    if not exchange then
      add_expert(root, E.unasked)
      return
    end
    add_frame(tree, tvb, F.command_in, exchange.command_in)
    add_frame(tree, tvb, F.routed_from, record.routed_from)
    if record.reaction_before then
      add_expert(root, E.answered_before,
        strformat("The command was answered before, in frame %d", record.reaction_before))
    elseif exchange.reaction_time and tree then
      set_generated(add_value(tree, F.reaction_time, tvb, 0, 0, nstime(exchange.reaction_time),
        strformat("%.3f ms", exchange.reaction_time / 1e6)))
    end
  end

  -- Adds what is known of the exchange to the tree, and marks.
  function S.exchange_show(record, telegram, body)
    local exchange = record.exchange

    if exchange then
      set_generated(add(body.tree, F.stream, body.tvb, 0, 0, exchange.from.stream.number))
    end
    if telegram.is_reaction then
      show_reaction(record, body)
    elseif exchange then
      show_command(exchange, body)
    end
  end
end
