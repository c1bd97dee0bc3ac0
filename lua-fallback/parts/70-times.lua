
-- times (sis-times.c): when characters came, and how exactly that is known.
--
-- A character has the time of the read that delivered it, the latest at which it can have come; it came no earlier than
-- the record's uncertainty before that. Characters of one read follow one another by at least a character time, so the
-- i-th of k came at least (k - i) character times before the read, and if the read is longer than its uncertainty, the
-- uncertainty was too small.

K.TIME_OK, K.TIME_EXCEEDED, K.TIME_UNRESOLVED = 0, 1, 2
K.ANY_TIME = math.huge -- the most, where there is no bound

do
  local interval_of, flags_of = T.interval_of, T.flags_of

  -- The shortest time of a character; a little short: a transmitter may be that much faster than its rate says.
  local function shortest_character(record)
    return floor(T.character_ns(record) * 98 / 100)
  end

  -- How many characters of the telegram came in the read that begins with `character`.
  local function read_size(times, character)
    local record, finish, after = times.record, times.first + times.count, character + 1

    if band(record.flags, K.SAME_READ) == 0 then return 1 end
    while after < finish and band(flags_of(record, after), K.SAME_READ) ~= 0 do
      after = after + 1
    end
    return after - character
  end

  -- A read of some of the telegram's characters: how long before it its first one can have come (uncertainty), and how
  -- much of that its others need, from the first character to the last, at least; ns.
  local function read_at(times, character)
    local record, size = times.record, read_size(times, character)
    local others = size > 1 and (size - 1) * shortest_character(record) or 0

    return {size = size, uncertainty = max(record.uncertainty or K.ANY_TIME, others), others = others}
  end

  local function bound_begin(times)
    local read = read_at(times, times.first)

    times.begin_earliest = times.begin - read.uncertainty
    times.begin_latest = times.begin - read.others
  end

  local function bound_end(times)
    local last = times.first + times.count - 1

    while last > times.first and band(flags_of(times.record, last), K.SAME_READ) ~= 0 do
      last = last - 1
    end
    local read = read_at(times, last)

    times.end_earliest = times.end_ - read.uncertainty + read.others
  end

  -- From the time of character `first` to that of `last`.
  local function duration(record, first, last)
    local ns = 0

    for i = first + 1, last do
      ns = ns + interval_of(record, i)
    end
    return ns
  end

  -- The times of the telegram that `tvb` begins with, in ns; record is nil where only the time of its packet is known:
  -- {record, first, count: of the record's characters, begin, end_: as recorded, begin_earliest, begin_latest,
  -- end_earliest: nil where they are not known}.
  function S.times(tvb, pinfo, length)
    local record, begin = T.record(pinfo), S.packet_time(pinfo)
    local first = record and T.index(record, tvb)

    if not record or length == 0 or first < 0 or first + length > record.timed then
      return {begin = begin, end_ = begin}
    end
    begin = begin + duration(record, 0, first)
    local end_ = begin + (length == record.timed and record.duration or duration(record, first, first + length - 1))
    local uncertainty = record.uncertainty
    local times = { -- as they are where every character came in a read of its own
      record = record,
      first = first,
      count = length,
      begin = begin,
      end_ = end_,
      begin_earliest = uncertainty and begin - uncertainty,
      begin_latest = uncertainty and begin,
      end_earliest = uncertainty and end_ - uncertainty,
    }

    if uncertainty and band(record.flags, K.SAME_READ) ~= 0 then
      bound_begin(times)
      bound_end(times)
    end
    return times
  end

  local NOT_MEASURED = K.INTERVAL_UNKNOWN + K.INTERVAL_SATURATED + K.LOST_BEFORE
  local UNKNOWN_OR_LOST = K.INTERVAL_UNKNOWN + K.LOST_BEFORE
  local UNKNOWN_OR_SATURATED = K.INTERVAL_UNKNOWN + K.INTERVAL_SATURATED

  -- Between the last character of one read and the first of the next.
  local function span_before(times, before, read, character)
    local flags, interval = flags_of(times.record, character), interval_of(times.record, character)
    local least = interval - read.uncertainty
    local most = interval - read.others + before.uncertainty - before.others

    if not times.record.uncertainty then return {least = 0, most = K.ANY_TIME} end
    if band(flags, UNKNOWN_OR_LOST) ~= 0 then least = 0 end
    if band(flags, UNKNOWN_OR_SATURATED) ~= 0 then most = K.ANY_TIME end
    return {least = max(least, 0), most = most}
  end

  -- Between any two characters of one read: bounded by what the others leave of its uncertainty, and of the time since
  -- the read before.
  local function span_inside(times, before, read, character)
    local shortest = shortest_character(times.record)
    local most = read.uncertainty - read.others + shortest

    if not times.record.uncertainty then
      most = K.ANY_TIME
    elseif before then
      most = min(most, span_before(times, before, read, character).most)
    end
    return {least = shortest, most = max(most, shortest)}
  end

  -- A start character and two equal lengths: there a receiver begins anew after too long a pause, if the character
  -- comes directly after it (chapter 10.5).
  local function looks_like_start(times, at)
    local record = times.record
    local start, _, length, length_repeat = byte(record.bytes, record.data_offset + times.first + at,
      record.data_offset + times.first + at + 3)

    return start == K.START and at + 3 <= times.count and length == length_repeat
  end

  -- By how much an interval counts.
  local function weight(interval, is_exceeded)
    if is_exceeded then return interval.span.least end
    return interval.span.most ~= K.ANY_TIME and interval.span.most or interval.recorded
  end

  local function consider(longest, times, interval, limit)
    local flags, verdict = flags_of(times.record, times.first + interval.at - 1), S.judge(interval.span, limit)
    local is_exceeded, was_exceeded = verdict == K.TIME_EXCEEDED, longest.verdict == K.TIME_EXCEEDED

    if is_exceeded and not longest.restart_at and looks_like_start(times, interval.at) then
      longest.restart_at = interval.at
    end
    if longest.verdict == K.TIME_OK or is_exceeded then longest.verdict = verdict end
    if band(flags, UNKNOWN_OR_LOST) ~= 0 then
      if verdict == K.TIME_UNRESOLVED then longest.unknown_at = longest.unknown_at or interval.at end
      return
    end
    interval.is_saturated = band(flags, K.INTERVAL_SATURATED) ~= 0
    interval.weight = weight(interval, is_exceeded)
    if not longest.interval or (is_exceeded and not was_exceeded)
      or (is_exceeded == was_exceeded and interval.weight > longest.interval.weight) then
      longest.interval = interval
    end
  end

  -- The interval that is, or may be, the longest of a telegram: one that exceeds the limit where there is one. With the
  -- verdict over all of them, the first character after too long a pause where a telegram seems to begin (restart_at),
  -- and the one before which nobody knows how long it was, and it matters (unknown_at). An interval: {at: number of the
  -- character in the telegram, from 1, recorded, span, weight: the largest is the longest, is_exact: both its
  -- characters came alone, each in a read of its own, is_saturated: it was longer than recorded}; nil where there is
  -- none.
  function S.longest(times, limit)
    local longest = {verdict = K.TIME_OK}
    local before
    local character, finish = times.first, times.first + times.count

    while character < finish do
      local read, at = read_at(times, character), character - times.first + 1

      if before then
        consider(longest, times, {
          at = at,
          recorded = interval_of(times.record, character),
          is_exact = read.size == 1 and before.size == 1,
          span = span_before(times, before, read, character),
        }, limit)
      end
      if read.size > 1 then
        consider(longest, times, {at = at + 1, recorded = 0, span = span_inside(times, before, read, character)}, limit)
      end
      before = read
      character = character + read.size
    end
    return longest.interval and longest
  end

  -- Whether all intervals are within the limit, whatever the uncertainty: quicker than to look at each of them.
  function S.are_within(times, limit)
    local record = times.record

    return record.uncertainty
      and band(record.flags, NOT_MEASURED) == 0
      and max(record.interval_max, shortest_character(record)) + record.uncertainty <= limit
  end

  -- From the end of one telegram to the beginning of another.
  function S.span_between(end_earliest, end_, after)
    return {least = after.begin_earliest - end_, most = after.begin_latest - end_earliest}
  end

  -- exceeded, ok or unresolved (see plugin/README.md); the limit in ns.
  function S.judge(span, limit)
    if span.least > limit then return K.TIME_EXCEEDED end
    return span.most <= limit and K.TIME_OK or K.TIME_UNRESOLVED
  end
end
