
-- timing (sis-timing.c): verdicts on the timing of telegrams: TzA, TrS, TwM and Tmas (chapter 10), and how busy the bus
-- is. A limit comes from a preference, else from what the bus has told, else there is none, and no verdict; nor is
-- there one where only packets have times.

do
  local MS = 1000000 -- in ns
  local OPERATOR_TERMINAL_SILENCE = 200 * MS -- after it an operator terminal takes its link for lost (chapter 10.1)

  local verdicts = {
    [K.TIME_OK] = "ok",
    [K.TIME_EXCEEDED] = "exceeded",
    [K.TIME_UNRESOLVED] = "unresolved: the times are not exact enough",
  }

  field("silence_before", "Silence before", "sis.silence_before", ftypes.RELATIVE_TIME, nil, nil, 0,
    "Since the character before it on this line, arrival to arrival")
  field("tza_interval_max", "Longest interval", "sis.tza.interval_max", ftypes.RELATIVE_TIME, nil, nil, 0,
    "Between two characters of the telegram, arrival to arrival; "
      .. "where they came in one read, the most it can have been")
  field("tza_position", "Longest interval before character", "sis.tza.position", ftypes.UINT16, base.DEC, nil, 0,
    "Its number in the telegram, from 1")
  field("tza_limit", "TzA (longest interval allowed)", "sis.tza.limit", ftypes.RELATIVE_TIME)
  field("tza_set_in", "TzA set in", "sis.tza.set_in", ftypes.FRAMENUM, base.NONE)
  field("tza_verdict", "Verdict on TzA", "sis.tza.verdict", ftypes.UINT8, base.DEC, verdicts)
  field("trs_limit", "TrS (longest reaction time allowed)", "sis.trs.limit", ftypes.RELATIVE_TIME)
  field("trs_set_in", "TrS set in", "sis.trs.set_in", ftypes.FRAMENUM, base.NONE)
  field("trs_verdict", "Verdict on TrS", "sis.trs.verdict", ftypes.UINT8, base.DEC, verdicts)
  field("twm_wait", "Wait of the master (TwM)", "sis.twm.wait", ftypes.RELATIVE_TIME, nil, nil, 0,
    "Since the end of its command before: of the one that is repeated, or of a broadcast")
  field("tmas_cycle", "Master control word cycle", "sis.tmas.cycle", ftypes.RELATIVE_TIME, nil, nil, 0,
    "Between two writings of S-0-0134 to the same device, begin to begin")
  field("tmas_limit", "Tmas (longest cycle allowed)", "sis.tmas.limit", ftypes.RELATIVE_TIME, nil, nil, 0,
    "While the machine moves")
  field("tmas_set_in", "Tmas set in", "sis.tmas.set_in", ftypes.FRAMENUM, base.NONE)
  field("tmas_verdict", "Verdict on Tmas", "sis.tmas.verdict", ftypes.UINT8, base.DEC, verdicts)
  field("bus_baud", "Baud rate of the bus", "sis.bus.baud", ftypes.UINT32, base.DEC, nil, 0, "As the bus was told")
  field("bus_baud_set_in", "Baud rate set in", "sis.bus.baud.set_in", ftypes.FRAMENUM, base.NONE)
  field("bus_load", "Bus load", "sis.bus.load", ftypes.DOUBLE, nil, nil, 0,
    "Percent of the last second in which there were characters on the line")

  expert_field("tza_exceeded", "sis.tza.exceeded", "PROTOCOL", "WARN", "TzA exceeded")
  expert_field("tza_unresolved", "sis.tza.unresolved", "PROTOCOL", "NOTE", "TzA perhaps exceeded")
  expert_field("trs_exceeded", "sis.trs.exceeded", "PROTOCOL", "WARN", "TrS exceeded")
  expert_field("trs_unresolved", "sis.trs.unresolved", "PROTOCOL", "NOTE", "TrS perhaps exceeded")
  expert_field("twm_early", "sis.twm.early", "SEQUENCE", "NOTE", "Repeated before TrS was over")
  expert_field("tmas_exceeded", "sis.tmas.exceeded", "PROTOCOL", "WARN", "Tmas exceeded")
  expert_field("tmas_unresolved", "sis.tmas.unresolved", "PROTOCOL", "NOTE", "Tmas perhaps exceeded")
  expert_field("baud_differs", "sis.bus.baud.differs", "PROTOCOL", "NOTE",
    "The tap listens at another baud rate than the bus was told")

  -- 0: what the bus has told.
  preference("tza_ms", Pref.uint("TzA in ms", 0,
    "Longest interval allowed between two characters of a telegram; 0: as the bus was told"))
  preference("trs_ms", Pref.uint("TrS in ms", 0, "Longest reaction time allowed; 0: as the bus was told"))

  -- The three limits, and how they are shown.
  local tza = {name = "TzA", limit = F.tza_limit, set_in = F.tza_set_in, verdict = F.tza_verdict,
    exceeded = E.tza_exceeded, unresolved = E.tza_unresolved}
  local trs = {name = "TrS", limit = F.trs_limit, set_in = F.trs_set_in, verdict = F.trs_verdict,
    exceeded = E.trs_exceeded, unresolved = E.trs_unresolved}
  local tmas = {name = "Tmas", limit = F.tmas_limit, set_in = F.tmas_set_in, verdict = F.tmas_verdict,
    exceeded = E.tmas_exceeded, unresolved = E.tmas_unresolved}

  -- More digits where three would make it look like a whole number of ms, as limits are.
  local function ms_text(ns)
    local is_close = fmod(ns, MS) ~= 0 and fmod(ns + 500, MS) < 1000

    return strformat(is_close and "%.6f ms" or "%.3f ms", ns / MS)
  end

  local function span_text(span)
    if span.most == K.ANY_TIME then
      return span.least > 0 and "at least " .. ms_text(span.least) or "not known"
    end
    return strformat("between %s and %s", ms_text(max(span.least, 0)), ms_text(span.most))
  end

  -- A telegram whose timing is looked at (t): {telegram, record, body, tree, root: of `tree`; in ns silence (nil: not
  -- known), tza and trs: limits (0: not known, so there is no verdict), longest (nil: not known, or nobody asks), wait:
  -- TwM (negative: none)}.

  local function add_time(t, which, ns, text)
    local item = t.tree and add_value(t.tree, which, t.body.tvb, 0, 0, nstime(ns), text)

    return set_generated(item)
  end

  local function add_uint(t, which, value, text)
    local item = add(t.tree, which, t.body.tvb, 0, 0, value)

    append_text(item, text or "")
    return set_generated(item)
  end

  local function setting(t, kind)
    return t.record.settings and t.record.settings[kind]
  end

  -- In ns; 0: there is none.
  local function limit_of(t, kind, preference_ms)
    local told = setting(t, kind)

    if preference_ms ~= 0 then return preference_ms * MS end
    return told and told.value * MS or 0
  end

  -- Limit and verdict, with the words for an expert item.
  local function show_verdict(t, judgement, told, limit, verdict, words)
    local limit_text = strformat("%d ms", limit / MS)

    add_time(t, judgement.limit, limit, limit_text)
    if told then add_uint(t, judgement.set_in, told.set_in) end
    local item = add_uint(t, judgement.verdict, verdict)

    if verdict == K.TIME_OK then return end
    local is_exceeded = verdict == K.TIME_EXCEEDED

    add_expert(item or t.root, is_exceeded and judgement.exceeded or judgement.unresolved,
      strformat("%s = %s %s: %s", judgement.name, limit_text, is_exceeded and "exceeded" or "perhaps exceeded", words))
    if is_exceeded then
      t.body.marks = t.body.marks .. strformat("  [%s exceeded]", judgement.name)
    end
  end

  local header = {"Start", "Checksum", "Data length", "Data length repetition", "Telegram control", "Service",
    "Sender address", "Receiver address"}

  -- The field that the n-th character of a telegram belongs to, from 1.
  local function position_text(t, n)
    local telegram = t.telegram
    local subaddress = n - K.STATIC_LENGTH

    if header[n] then return header[n] end
    if subaddress <= telegram.subaddress_count then return strformat("Subaddress %d", subaddress) end
    if n <= telegram.body_offset then return "Telegram number" end
    return strformat("Useful data, byte %d", n - telegram.body_offset)
  end

  -- What makes a verdict unresolved beside the longest interval, or what a receiver does after so long a pause (chapter
  -- 10.5).
  local function verdict_words(longest)
    if longest.verdict == K.TIME_UNRESOLVED and longest.unknown_at then
      return strformat("; how long it was before character %d is not known", longest.unknown_at)
    end
    if longest.verdict ~= K.TIME_EXCEEDED then return "" end
    if longest.restart_at then
      return strformat("; character %d looks like the start of a telegram: a receiver begins anew there",
        longest.restart_at)
    end
    return "; a receiver goes on"
  end

  -- "12.000 ms (idle 10.854 ms": the part without the character itself.
  local function idle_text(t, ns)
    local idle = ns - T.character_ns(t.telegram.times.record)

    return strformat("%s (idle %s", ms_text(ns), ms_text(max(idle, 0)))
  end

  local function interval_text(t, interval)
    local uncertainty = t.telegram.times.record.uncertainty

    if interval.is_saturated then return "at least " .. ms_text(interval.recorded) end
    if not interval.is_exact then return span_text(interval.span) end
    if not uncertainty then return idle_text(t, interval.recorded) .. ", uncertainty unknown)" end
    return strformat("%s, uncertain by %s)", idle_text(t, interval.recorded), ms_text(uncertainty))
  end

  -- The longest interval, where it is, and what TzA says to it.
  local function show_tza(t)
    local longest = t.longest
    local interval = longest.interval
    local text, position = interval_text(t, interval), position_text(t, interval.at)

    if interval.is_exact or interval.is_saturated then
      add_time(t, F.tza_interval_max, interval.recorded, text)
    elseif interval.span.most ~= K.ANY_TIME then
      add_time(t, F.tza_interval_max, interval.span.most, text)
    end
    add_uint(t, F.tza_position, interval.at, " (" .. position .. ")")
    if t.tza ~= 0 then
      show_verdict(t, tza, P.tza_ms == 0 and setting(t, K.TZA), t.tza, longest.verdict,
        strformat("%s before character %d (%s)%s", text, interval.at, position, verdict_words(longest)))
    end
  end

  -- The reaction time of a slave on this line; behind a router it holds times of other lines.
  local function show_trs(t)
    local exchange, times = t.record.exchange, t.telegram.times
    local span, words = {least = 0, most = K.ANY_TIME}, function() return "how exact the times are is not known" end

    if times.begin_earliest and exchange.command_end_earliest then
      span, words = S.span_between(exchange.command_end_earliest, exchange.command_end, times), span_text
    end
    local verdict = S.judge(span, t.trs)

    if t.tree or verdict ~= K.TIME_OK then
      show_verdict(t, trs, P.trs_ms == 0 and setting(t, K.TRS), t.trs, verdict, words(span))
    end
  end

  -- How long the master waited before it repeated, or after a broadcast. Nobody is told TwM, but a slave may take TrS
  -- to answer.
  local function show_twm(t)
    local wait, slave = t.wait, limit_of(t, K.TRS, P.trs_ms)
    local item = add_time(t, F.twm_wait, wait, ms_text(wait))

    if t.record.exchange.repeat_of and slave > 0 and wait < slave then
      add_expert(item or t.root, E.twm_early,
        strformat("Repeated after %s, while the slave may take %d ms (TrS)", ms_text(wait), slave / MS))
    end
  end

  local function show_tmas(t)
    local cycle, longest = t.record.cycle, t.telegram.times.record and limit_of(t, K.TMAS, 0) or 0

    add_time(t, F.tmas_cycle, cycle.ns, ms_text(cycle.ns))
    if longest > 0 then
      show_verdict(t, tmas, setting(t, K.TMAS), longest, S.judge(cycle.span, longest),
        strformat("%s since the master control word before (frame %d); a slave stops a movement", ms_text(cycle.ns),
          cycle.frame))
    end
  end

  local function show_baud(t, rate)
    local tap = t.telegram.times.record
    local item = add_uint(t, F.bus_baud, rate.value, rate.accepted_in and " Bd" or " Bd (timed test)")

    add_uint(t, F.bus_baud_set_in, rate.set_in)
    if tap and tap.baud ~= 0 and tap.baud ~= rate.value then
      add_expert(item or t.root, E.baud_differs,
        strformat("The bus was told %d Bd, the tap listens at %d Bd", rate.value, tap.baud))
    end
  end

  local function show_bus(t)
    local rate, record = setting(t, K.BAUD), t.record

    if rate then show_baud(t, rate) end
    if record.busy and t.tree then
      local load = T.percent(record.busy, record.span)

      set_generated(add_value(t.tree, F.bus_load, t.body.tvb, 0, 0, load, strformat("%.1f %%", load)))
    end
  end

  local function show_silence(t)
    local silence = t.silence
    local item = t.tree and add_time(t, F.silence_before, silence, idle_text(t, silence) .. ")")

    if silence > OPERATOR_TERMINAL_SILENCE then
      append_text(item, ", more than the 200 ms after which an operator terminal gives up")
    end
  end

  local SILENCE_UNKNOWN = K.INTERVAL_UNKNOWN + K.INTERVAL_SATURATED + K.LOST_BEFORE + K.SAME_READ

  -- Before the telegram's first character, since the one before it on the line; nil where it is not known.
  local function silence_before(times)
    local record = times.record

    if record and band(T.flags_of(record, times.first), SILENCE_UNKNOWN) == 0 then
      return T.interval_of(record, times.first)
    end
  end

  -- Looking at every interval costs time: only where somebody sees it, or it may exceed a limit.
  local function is_longest_wanted(t)
    local tree, times = t.body.tree, t.telegram.times

    if not times.record then return false end
    if t.tza > 0 then return tree or not S.are_within(times, t.tza) end
    return tree and (tree:referenced(F.tza_interval_max) or tree:referenced(F.tza_position))
  end

  local function find_timing(t)
    local telegram, record = t.telegram, t.record
    local exchange = record.exchange
    local is_answer = telegram.is_good and telegram.is_reaction and exchange and exchange.reaction_time
      and not record.reaction_before

    t.silence = silence_before(telegram.times)
    t.tza = limit_of(t, K.TZA, P.tza_ms)
    if is_longest_wanted(t) then t.longest = S.longest(telegram.times, t.tza) end
    t.trs = is_answer and telegram.subaddress_count == 0 and telegram.times.record
      and limit_of(t, K.TRS, P.trs_ms) or 0
    t.wait = exchange and not telegram.is_reaction and exchange.wait or -1
  end

  local function is_anything_known(t)
    return t.silence or t.longest or t.trs > 0 or t.wait >= 0 or t.record.cycle or setting(t, K.BAUD) or t.record.busy
  end

  local function show(t)
    local body = t.body

    t.tree = set_generated(add_subtree(body.tree, body.tvb, 0, 0, "Timing"))
    t.root = t.tree or body.root
    if t.silence then show_silence(t) end
    if t.longest then show_tza(t) end
    if t.trs > 0 then show_trs(t) end
    if t.wait >= 0 then show_twm(t) end
    if t.record.cycle then show_tmas(t) end
    show_bus(t)
  end

  -- Whether a command writes the master control word: S-0-0134 of SERCOS. The documents do not say which telegram
  -- brings it.
  local function find_control_word(request)
    local ident = request.ident

    if ident and ident.type == 0 and ident.number == 134 and request.element == K.ELEMENT_DATA
      and S.general_service(request.service) == 0x1F then
      return request
    end
    local element = request.list

    while element do
      if find_control_word(element) then return element end
      element = element.next
    end
  end

  -- Two master control words to the same drive: the frame of the one before, and the time from begin to begin.
  local function make_cycle(last, times)
    local before = last.times
    local span = {least = 0, most = K.ANY_TIME}

    if times.begin_earliest and before.begin_earliest then
      span.least = times.begin_earliest - before.begin_latest
      span.most = times.begin_latest - before.begin_earliest
    end
    return {frame = last.frame, ns = times.begin - before.begin, span = span}
  end

  local function note_cycle(record, telegram, body)
    local exchange = record.exchange
    local request = exchange and body.request and find_control_word(body.request)

    if not request then return end
    local cycles, times = exchange.from.stream.bus.cycles, telegram.times
    local key = exchange.from.stream.number * 256 + (request.device or 0)

    if cycles[key] then record.cycle = make_cycle(cycles[key], times) end
    cycles[key] = {frame = body.pinfo.number, times = times}
  end

  -- First pass: what is valid for a telegram that has just come. A swapped reaction's slave is in its command.
  function S.timing_note(record, telegram, pinfo)
    if pinfo.visited then return end
    local exchange = record.exchange
    local bus = exchange and exchange.from.stream.bus or S.exchange_bus(pinfo)
    local address = exchange and byte(exchange.path) or telegram.receiver

    if not telegram.is_good or not S.is_answered(address) then address = K.ALL_STATIONS end
    record.settings = S.bus_settings(bus.told, address, telegram.times.begin)
    if telegram.times.record then record.busy, record.span = T.load(telegram.times.record) end
  end

  -- Adds what is known of a telegram's timing to its tree, and marks. `body` has been taken apart.
  function S.timing_dissect(telegram, record, body)
    if not body.pinfo.visited then note_cycle(record, telegram, body) end
    if not body.tree and not record.settings and P.tza_ms == 0 and P.trs_ms == 0 then return end -- nothing to be seen
    local t = {telegram = telegram, record = record, body = body}

    find_timing(t)
    if (body.tree or t.tza > 0 or t.trs > 0 or record.cycle) and is_anything_known(t) then show(t) end
  end
end
