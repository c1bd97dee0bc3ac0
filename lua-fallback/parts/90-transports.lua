
-- sis-transports: where SIS telegrams come from besides the serial tap: TCP, RTAC serial captures, a user link type

do
  local SIP_PORT = 35021 -- S/IP, another protocol of the same drives
  local DLT_USER_OFF = -1

  local choices = {{"off", "Off", DLT_USER_OFF}}

  for number = 0, 15 do
    choices[number + 2] = {strformat("user%d", number), strformat("USER%d (%d)", number, 147 + number), number}
  end
  preference("dlt_user", Pref.enum("Decode a user link type as SIS", DLT_USER_OFF,
    "Captures of this link type hold bare telegrams. Goes before the table of protocol DLT_USER while it is set",
    choices, false))
  preference("tcp_heuristic", Pref.bool("Recognize SIS on any TCP port", true,
    "Where a segment starts with a whole telegram: equal lengths, right checksum"))

  -- Whether a telegram may begin at this start character, as far as the bytes that are there can tell.
  local function may_begin(bytes, offset)
    local there = #bytes - offset

    return there < 4 or S.declared_length(bytes, offset) > there or S.is_good(bytes, offset)
  end

  -- For dissect_tcp_pdus(): the length of the telegram at offset; where there is none (a segment was lost, the capture
  -- began in the middle) that of what goes before the next one; 0 if more bytes are needed to tell.
  local function telegram_length(tvb, pinfo, offset)
    local bytes, rest = tvb:raw(), tvb:reported_len() - offset
    local next_start = offset

    if byte(bytes, offset + 1) == K.START then
      local declared = S.declared_length(bytes, offset)

      if declared > 0 then return declared end
      if #bytes - offset < 4 then return pinfo.can_desegment > 0 and 0 or rest end
    end
    repeat
      next_start = string.find(bytes, char(K.START), next_start + 2, true)
      next_start = next_start and next_start - 1
    until not next_start or may_begin(bytes, next_start)
    return next_start and next_start - offset or rest
  end

  -- Something may be in the info column: another telegram of this packet, or TCP's words, which end with a space.
  local function separator(info)
    local last = sub(tostring(info), -1)

    return (last == "" or last == " ") and "" or " | "
  end

  -- The columns are ours only where a telegram ends: of a segment with just a part of one TCP says what it is. The
  -- fence keeps what the telegrams before this one wrote.
  local function dissect_pdu(tvb, pinfo, tree)
    local cols = pinfo.cols

    cols.protocol = "SIS"
    cols.info:clear()
    local words = S.dissect_telegram(tvb, pinfo, tree, tvb:reported_len())
    cols.info:append(separator(cols.info) .. words)
    if tvb:len() < tvb:reported_len() then S.show_cut(tvb, pinfo, tree, "SIS") end
    cols.info:fence()
    return tvb:len()
  end

  -- Telegrams split over segments and packed into them. Where the capture has cut a segment between two telegrams,
  -- TCP throws: an error without a message.
  local function dissect_segment(tvb, pinfo, tree)
    S.begin_packet(pinfo)
    local is_done, message = pcall(dissect_tcp_pdus, tvb, tree, 1, telegram_length, dissect_pdu)
    if message then error(message, 0) end
    if not is_done then S.show_cut(tvb, pinfo, tree, "SIS") end
  end

  -- USIP and others start with 0x02, too: only a whole telegram with equal lengths and a zero checksum counts, and what
  -- follows it has to be another one.
  local function is_sis(bytes)
    local declared = S.declared_length(bytes, 0)

    return S.is_good(bytes, 0) and (declared == #bytes or byte(bytes, declared + 1) == K.START)
  end

  local recognized_in = {} -- by connection: the first packet of SIS

  at_init(function() recognized_in = {} end)

  local function dissect_tcp_heuristic(tvb, pinfo, tree)
    if not P.tcp_heuristic or pinfo.src_port == SIP_PORT or pinfo.dst_port == SIP_PORT or not is_sis(tvb:raw()) then
      return false
    end
    local connection = S.connection(pinfo)

    recognized_in[connection] = recognized_in[connection] or pinfo.number
    pinfo.conversation = sis
    dissect_segment(tvb, pinfo, tree)
    return true
  end

  -- What came before the packet in which SIS was recognized was something else, in the second pass, too: then 0.
  function S.dissect_tcp(tvb, pinfo, tree)
    local first = recognized_in[S.connection(pinfo)]

    if first and pinfo.number < first then return 0 end
    dissect_segment(tvb, pinfo, tree)
    return tvb:len()
  end

  -- An entry of "wtap_encap" silently goes before the user's own DLT_USER table: so none before it is asked for, and
  -- the link type is handed back to that table afterwards. At each file, and not when preferences are applied.
  local taken = DLT_USER_OFF

  local function apply_dlt_user()
    local encapsulations = DissectorTable.get("wtap_encap")

    if P.dlt_user == taken then return end
    if taken ~= DLT_USER_OFF then
      encapsulations:remove(wtap.USER0 + taken, sis)
      encapsulations:add(wtap.USER0 + taken, Dissector.get("user_dlt"))
    end
    if P.dlt_user ~= DLT_USER_OFF then encapsulations:add(wtap.USER0 + P.dlt_user, sis) end
    taken = P.dlt_user
  end

  at_init(apply_dlt_user)

  local function all_of(declared)
    local list = {}

    for _, each in pairs(declared) do
      list[#list + 1] = each
    end
    return list
  end

  sertap.fields, sertap.experts = all_of(FT), all_of(ET)
  sis.fields, sis.experts = all_of(F), all_of(E)

  DissectorTable.get("sertap.framing"):add(0, sis)
  DissectorTable.get("tcp.port"):add_for_decode_as(sis)
  DissectorTable.get("rtacser.data"):add_for_decode_as(sis)
  sis:register_heuristic("tcp", dissect_tcp_heuristic)
end
