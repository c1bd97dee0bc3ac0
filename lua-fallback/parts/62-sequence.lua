
-- sequence (sis-sequence.c): sequential telegrams: data that do not fit into one are read or written in pieces
-- (chapters 8.2 and 8.7). Bit 2 of the parameter control says whether more follow; nothing says that a piece is the
-- first, or which one it is.

do
  field("pieces", "Pieces", "sis.sequence", ftypes.NONE)
  field("piece", "Piece", "sis.sequence.piece", ftypes.FRAMENUM, base.NONE)
  field("overlap", "Overlap", "sis.sequence.overlap", ftypes.BOOLEAN)
  field("overlap_conflict", "Overlap with other data", "sis.sequence.overlap.conflict", ftypes.BOOLEAN)
  field("multiple_tails", "Several last pieces", "sis.sequence.multiple_tails", ftypes.BOOLEAN)
  field("too_long", "Piece too long", "sis.sequence.too_long", ftypes.BOOLEAN)
  field("sequence_error", "Error while putting together", "sis.sequence.error", ftypes.FRAMENUM, base.NONE)
  field("piece_count", "Number of pieces", "sis.sequence.count", ftypes.UINT32, base.DEC)
  field("whole_in", "The whole is in", "sis.sequence.whole_in", ftypes.FRAMENUM, base.NONE)
  field("whole_length", "Length of the whole", "sis.sequence.length", ftypes.UINT32, base.DEC, nil, nil, "In bytes")

  expert_field("ended", "sis.sequence.ended", "SEQUENCE", "NOTE", "A transfer of sequential telegrams ended unfinished")
  expert_field("piece_missing", "sis.sequence.piece_missing", "SEQUENCE", "NOTE",
    "A piece of this transfer may be missing: a damaged telegram and a repeat came between")

  local SERVICE_CHANNEL_BUSY = 0x8001 -- the command was not executed, and is to be repeated
  local PARAMETER_OCCUPIED = 0x800C

  local WHOLE = "Data of all pieces"

  -- A transfer: {service, element, device, ident, begun_in, last_in: the latest piece, damaged_count: of its bus, then,
  -- is_broken: a piece may be missing, and the pieces are no longer put together, pieces: {frame, length}, whole_in,
  -- bytes: of the whole}. A record keeps the one that it is a piece of.

  -- Useful data, or what was put together from pieces: {tvb, offset, length, bytes}. A whole has its tvb where there is
  -- a tree.
  function S.data(body)
    local left = S.left(body)

    return {
      tvb = body.tvb,
      offset = body.offset,
      length = left,
      bytes = sub(body.bytes, body.offset + 1, body.offset + left),
    }
  end

  local function transfers_of(exchange)
    return exchange.from.transfers
  end

  local function is_same_transfer(a, b)
    return a.service == b.service
      and a.element == b.element
      and a.ident == b.ident
      and a.device == b.device
  end

  -- Its place among those under way; nil if it is not.
  local function find_transfer(exchange, like)
    for i, transfer in ipairs(transfers_of(exchange)) do
      if is_same_transfer(transfer, like) then
        return i, transfer
      end
    end
  end

  -- A step that was taken before: the same command again, or its reaction again.
  local function is_taken_before(body)
    local record, exchange = body.record, body.record.exchange

    if body.is_reaction then return record.reaction_before ~= nil or exchange.is_kept_reaction_seen end
    return exchange.repeat_of ~= nil
  end

  local function damaged_since(transfer, exchange)
    return exchange.from.stream.bus.damaged_count - transfer.damaged_count
  end

  -- Whether something since the piece before may have been a piece: lost characters; the damaged reaction to a command
  -- that was repeated then; or a damaged command with its damaged reaction. Not where the slave sends the reaction
  -- again that it has kept.
  local function is_piece_missing(body, transfer)
    local exchange = body.record.exchange
    local enough = body.is_reaction and exchange.repeat_of and 1 or 2

    if exchange.from.stream.bus.lost_in > transfer.last_in then
      return true
    end
    return not exchange.is_reaction_kept and damaged_since(transfer, exchange) >= enough
  end

  -- Adds the piece to those before it.
  local function add_piece(transfer, frame, bytes, is_last)
    local pieces = transfer.pieces

    pieces[#pieces + 1] = {frame = frame, bytes = bytes}
    if not is_last then
      return
    end
    local all = {}

    for i, piece in ipairs(pieces) do
      all[i], piece.length, piece.bytes = piece.bytes, #piece.bytes, nil
    end
    transfer.bytes, transfer.whole_in = concat(all), frame
  end

  -- Whose piece these data are; decided once, in the order of the capture.
  local function place_piece(body, like, is_last)
    local record, frame = body.record, body.pinfo.number
    local exchange = record.exchange
    local place, transfer = find_transfer(exchange, like)

    record.is_piece_repeated = is_taken_before(body)
    if not transfer and (is_last or record.is_piece_repeated) then
      record.transfer = record.is_piece_repeated and exchange.transfer or nil -- of one that is over
      return
    end
    if not transfer then
      transfer = like
      transfer.begun_in, transfer.last_in, transfer.pieces = frame, frame, {}
      transfer.damaged_count = exchange.from.stream.bus.damaged_count
      place = #transfers_of(exchange) + 1
      transfers_of(exchange)[place] = transfer
    end
    record.transfer, exchange.transfer = transfer, transfer
    if not record.is_piece_repeated and is_piece_missing(body, transfer) then
      transfer.is_broken = true
    end
    record.is_piece_missing = transfer.is_broken
    if record.is_piece_repeated then
      return
    end
    transfer.last_in = frame
    transfer.damaged_count = exchange.from.stream.bus.damaged_count
    if not transfer.is_broken then
      add_piece(transfer, frame, S.data(body).bytes, is_last)
    end
    if is_last then
      table.remove(transfers_of(exchange), place)
    end
  end

  local function show_piece(tree, tvb, piece, offset)
    local words

    if piece.length == 0 then
      words = strformat("Frame: %d (no data)", piece.frame)
    else
      words = strformat("Frame: %d, payload: %d-%d (%d byte%s)", piece.frame, offset, offset + piece.length - 1,
        piece.length, plural(piece.length))
    end
    set_generated(add(tree, F.piece, tvb, offset, piece.length, piece.frame, words))
  end

  -- As Wireshark's own reassembly shows it.
  local function show_pieces(body, data, pieces)
    local numbers, offset = {}, 0

    for i, piece in ipairs(pieces) do
      numbers[i] = strformat("#%d(%d)", piece.frame, piece.length)
    end
    local tree = body.tree:add(F.pieces, data.tvb())

    tree:set_text(strformat("%d %s (%d byte%s): %s", #pieces, #pieces == 1 and "Piece" or "Pieces", data.length,
      plural(data.length), concat(numbers, ", ")))
    tree:set_generated()
    for _, piece in ipairs(pieces) do
      show_piece(tree, data.tvb, piece, offset)
      offset = offset + piece.length
    end
    set_generated(add(tree, F.piece_count, data.tvb, 0, 0, #pieces))
    set_generated(add(tree, F.whole_length, data.tvb, 0, 0, data.length))
  end

  local function put_together(body, is_last)
    local record = body.record
    local transfer = record.transfer

    body.item = body.root
    if record.is_piece_missing then
      S.mark(body, E.piece_missing, "a piece may be missing")
    end
    if record.is_piece_missing or record.is_piece_repeated or not transfer.whole_in then
      return nil
    end
    if not is_last then
      set_generated(add(body.tree, F.whole_in, body.tvb, 0, 0, transfer.whole_in))
      return nil
    end
    local data = {offset = 0, length = #transfer.bytes, bytes = transfer.bytes}

    if body.tree then
      data.tvb = ByteArray.new(data.bytes, true):tvb(WHOLE)
      show_pieces(body, data, transfer.pieces)
    end
    return data
  end

  local function make_like(body, ident, element, device)
    return {service = body.service, element = element, device = device, ident = ident}
  end

  local function is_outside(body)
    return body.is_nested or not body.record or not body.record.exchange
  end

  -- Whether a transfer of this parameter is under way: then its last piece may be empty.
  function S.is_sequence_open(body, ident, element, device)
    if is_outside(body) or not ident then
      return false
    end
    if body.pinfo.visited then
      return body.record.transfer ~= nil
    end
    return find_transfer(body.record.exchange, make_like(body, ident, element, device)) ~= nil
  end

  -- The data of a telegram that reads or writes a parameter, from body.offset to its end. `is_last` as its parameter
  -- control says. Adds what is known of the transfer. Gives the whole data where these are the last piece, nil where
  -- they are another, and the data themselves where they are alone.
  function S.sequence_data(body, ident, element, device, is_last)
    local record = body.record

    if is_outside(body) then
      return is_last and S.data(body) or nil
    end
    local is_alone = is_last and not next(transfers_of(record.exchange)) and not is_taken_before(body) -- as most are

    if not body.pinfo.visited and not is_alone then
      place_piece(body, make_like(body, ident, element, device), is_last)
    end
    if record.transfer then
      return put_together(body, is_last)
    end
    return S.data(body)
  end

  -- Whether these data are a piece.
  function S.is_piece(body)
    return body.record ~= nil and body.record.transfer ~= nil
  end

  local function end_with_note(record, place, reason)
    local transfers = transfers_of(record.exchange)

    record.transfer_ended = transfers[place].begun_in
    record.transfer_reason = reason
    table.remove(transfers, place)
  end

  -- Device and service may be missing; one byte alone may be either (chapter 4).
  local function is_cancelled(cancel, transfer)
    local is_device, is_service = transfer.device == cancel.device, transfer.service == cancel.subservice

    if cancel.has_device and cancel.has_subservice then
      return is_device and is_service
    end
    if cancel.is_ambiguous then
      return transfer.device == cancel.subservice or is_service
    end
    return true
  end

  -- Those for which `is_over` is true.
  local function end_transfers(record, reason, is_over)
    local transfers, place = transfers_of(record.exchange), 1

    while transfers[place] do
      if is_over(transfers[place]) then
        end_with_note(record, place, reason)
      else
        place = place + 1
      end
    end
  end

  local function watch_reaction(body)
    local record, asked = body.record, body.asked
    local status = body.status
    local like = make_like(body, asked.ident, asked.element, asked.device or 0) -- without an ident like none
    local place, transfer = find_transfer(record.exchange, like)
    -- Not executed, because the channel was busy or the command came damaged (0xF1, 0xF2, 0xF4): it comes again.
    local is_to_be_repeated = status == 0x02
      or body.error == SERVICE_CHANNEL_BUSY
      or body.error == PARAMETER_OCCUPIED
      or (status >= 0xF1 and status <= 0xF4)

    if transfer and record.reaction_before and damaged_since(transfer, record.exchange) > 0 then
      transfer.is_broken = true -- it answers a command that the tap alone saw damaged
    end
    if status == 0 then
      -- A device has one transfer at a time: when another parameter was accessed with success, it has given up the
      -- first.
      end_transfers(record, "another access to the device came between", function(other)
        return other.device == like.device and not is_same_transfer(other, like)
      end)
    elseif transfer and not is_to_be_repeated then
      end_with_note(record, place, "refused")
    end
  end

  local function watch(body)
    if not body.is_reaction or not body.asked or #transfers_of(body.record.exchange) == 0 then
      return
    end
    if body.service == 0x01 and body.status == 0 then
      end_transfers(body.record, "cancelled", function(transfer)
        return is_cancelled(body.asked, transfer)
      end)
    elseif S.has_control_byte(body.service) then
      watch_reaction(body)
    end
  end

  -- A good telegram that may end a transfer: cancelled, refused, or overtaken by another parameter of the same device.
  function S.sequence_watch(body)
    local record = body.record

    if is_outside(body) then
      return
    end
    if not body.pinfo.visited then
      watch(body)
    end
    if record.transfer_ended then
      body.item = body.root
      S.mark(body, E.ended, "transfer since frame %d ended unfinished: %s", record.transfer_ended,
        record.transfer_reason)
    end
  end
end
