# SPDX-License-Identifier: GPL-2.0-or-later
"""Logs as several programs write them, all of the same four telegrams of the specification (IF02)."""

from __future__ import annotations

from base64 import b64encode, urlsafe_b64encode
from typing import NamedTuple

from specification import TELEGRAMS

SET_RATE, READ_PHASE, PHASE = TELEGRAMS["6-14"], TELEGRAMS["8-20"], TELEGRAMS["8-21"]

SHARED, RECEIVED, SENT = 0, 1, 2


class Expected(NamedTuple):
    """A telegram of a log: the record's line, and ms since the first stamp, None where there are no stamps."""

    data: bytes
    line: int = SHARED
    time_ms: float | None = None


def _shared(*times_ms: float) -> list[Expected]:
    return [
        Expected(data, SHARED, time_ms) for data, time_ms in zip((SET_RATE, READ_PHASE, PHASE), times_ms, strict=True)
    ]


NO_TIMES = [Expected(SET_RATE), Expected(READ_PHASE), Expected(PHASE)]
EVEN = NO_TIMES[1:]
SENT_AND_RECEIVED = [Expected(SET_RATE, SENT, 0), Expected(READ_PHASE, SENT, 100), Expected(PHASE, RECEIVED, 136)]
# A list of parameters is read, in rows of 16 bytes with the rest below: of each telegram one more.
LISTS = [
    bytes([2, 0x5A - 9 * more, 8 + more, 8 + more, *bytes.fromhex("00 10 10 03 3C 03 24 00 00 00 07 07"), *[7] * more])
    for more in range(8)
]
MARKED = [Expected(SET_RATE, SENT), Expected(READ_PHASE, SENT), Expected(PHASE, RECEIVED)]

LOGS: dict[str, tuple[str, list[Expected]]] = {
    "docklight": (
        "Docklight-Protokoll (HEX), begonnen 14.03.2013 08:20:00\r\n"
        "\r\n"
        "14.03.2013 08:21:14.541 [TX] - 02 D7 03 03 00 03 \r\n"
        "10 03 04 07 00 \r\n"
        "14.03.2013 08:21:14.641 [TX] - 02 6C 00 00 00 92 00 00 \r\n"
        "14.03.2013 08:21:14.677 [RX] - 02 56 02 02 10 92 00 00 00 02 \r\n",
        SENT_AND_RECEIVED,
    ),
    "docklight, 12-hour clock": (
        "3/14/2013 12:59:59.900 PM [TX] - 02 D7 03 03 00 03 10 03 04 07 00\r\n"
        "3/14/2013 1:00:00.000 PM [TX] - 02 6C 00 00 00 92 00 00\r\n"
        "3/14/2013 1:00:00.036 PM [RX] - 02 56 02 02 10 92 00 00 00 02\r\n",
        SENT_AND_RECEIVED,
    ),
    "docklight, decimal": (
        "14.03.2013 08:21:14.541 [TX] - 002 215 003 003 000 003 016 003 004 007 000\n"
        "14.03.2013 08:21:14.641 [TX] - 002 108 000 000 000 146 000 000\n"
        "14.03.2013 08:21:14.677 [RX] - 002 086 002 002 016 146 000 000 000 002\n",
        SENT_AND_RECEIVED,
    ),
    "hterm": ("02D70303000310030407\n00\n02 6C 00 00 00 92 00 00\n\n0256020210920000\n0002\n", NO_TIMES),
    "one line": ("02 D7 03 03 00 03 10 03 04 07 00 02 6C 00 00 00 92 00 00 02 56 02 02 10 92 00 00 00 02", NO_TIMES),
    "realterm": (
        "02D7030300031003040700\n026C000000920000\n02560202109200000002\n",
        NO_TIMES,
    ),
    "realterm, time stamps": (
        "1363249274.541 02D7030300031003040700\n"
        "1363249274.641 026C000000920000\n"
        "1363249274.677 02560202109200000002\n",
        _shared(0, 100, 136),
    ),
    "jpnevulator, one port": (
        "2013-03-14 08:21:14.541000: /dev/ttyUSB0\n"
        "02 D7 03 03 00 03 10 03 04 07 00                ...........\n"
        "2013-03-14 08:21:14.641000: /dev/ttyUSB0\n"
        "02 6C 00 00 00 92 00 00                         .l......\n"
        "2013-03-14 08:21:14.677000: /dev/ttyUSB0\n"
        "02 56 02 02 10 92 00 00 00 02                   .V........\n",
        _shared(0, 100, 136),
    ),
    "jpnevulator, two ports": (
        "2013-03-14 08:21:14.541000: /dev/ttyS0\n"
        "02 D7 03 03 00 03 10 03 04 07 00\n"
        "2013-03-14 08:21:14.641000: /dev/ttyS0\n"
        "02 6C 00 00 00 92\n"
        "2013-03-14 08:21:14.677000: /dev/ttyUSB0\n"
        "02 56 02 02 10 92 00 00 00 02\n"
        "2013-03-14 08:21:14.642000: /dev/ttyS0\n"
        "00 00\n",
        [Expected(SET_RATE, 1, 0), Expected(PHASE, 2, 136), Expected(READ_PHASE, 1, 100)],
    ),
    "arrows, text above the bytes": (
        "[2013-03-14 08:21:14.5410] → \ufffd\ufffd\nHEX:02 D7 03 03 00 03 10 03 04 07 00\n"
        "[2013-03-14 08:21:14.6410] → l\nHEX:02 6C 00 00 00 92 00 00\n"
        "[2013-03-14 08:21:14.6770] ← V\nHEX:02 56 02 02 10 92 00 00 00 02\n",
        SENT_AND_RECEIVED,
    ),
    "arrows without spaces": (
        "[08:21:14.541]发→◇02 D7 03 03 00 03 10 03 04 07 00 □\n"
        "[08:21:14.641]发→◇02 6C 00 00 00 92 00 00 □\n"
        "[08:21:14.677]收←◆02 56 02 02 10 92 00 00 00 02 \n",
        SENT_AND_RECEIVED,
    ),
    "stamps between the bytes": (
        "[08:21:14.541] 02 d7 03 03 00 03 10 03 04 07 00 [08:21:14.641] 02 6c 00 00 00 92 00 00 [08:21:14.677] 02 56\n"
        "02 02 10 92 00 00 00 02\n",
        _shared(0, 100, 136),
    ),
    "a byte a line": (
        "".join(f"08:21:14.541 {byte:02X}\n" for byte in SET_RATE)
        + "".join(f"08:21:14.641 {byte:02X}\n" for byte in READ_PHASE)
        + "".join(f"08:21:14.677 {byte:02X}\n" for byte in PHASE),
        _shared(0, 100, 136),
    ),
    "candump": (
        "(1363249274.541000) can0 TX - - 17F [11] 02 D7 03 03 00 03 10 03 04 07 00\n"
        "(1363249274.641000) can0 TX - - 17F [8] 02 6C 00 00 00 92 00 00\n"
        "(1363249274.677000) can0 RX - - 18F [10] 02 56 02 02 10 92 00 00 00 02\n",
        SENT_AND_RECEIVED,
    ),
    "hexdump -C": (
        "00000000  02 d7 03 03 00 03 10 03  04 07 00 02 6c 00 00 00  |............l...|\n"
        "00000010  92 00 00 02 56 02 02 10  92 00 00 00 02           |....V........|\n"
        "0000001d\n",
        NO_TIMES,
    ),
    "xxd": (
        "00000000: 02d7 0303 0003 1003 0407 0002 6c00 0000  ............l...\n"
        "00000010: 9200 0002 5602 0210 9200 0000 02         ....V........\n",
        NO_TIMES,
    ),
    "terminal with lengths": (
        "14-Mar-2013 08:21:14.541 Sent 11 bytes: 02 D7 03 03 00 03 10 03 04 07 00\n"
        "14-Mar-2013 08:21:14.641 Sent 8 bytes: 02 6C 00 00 00 92 00 00\n"
        "14-Mar-2013 08:21:14.677 Received 10 bytes: 02 56 02 02 10 92 00 00 00 02\n",
        SENT_AND_RECEIVED,
    ),
    "plc, iec 61131": (
        "08:21:14:541 SEND 16#02 16#D7 16#03 16#03 16#00 16#03 16#10 16#03 16#04 16#07 16#00\n"
        "08:21:14:641 SEND 16#02 16#6C 16#00 16#00 16#00 16#92 16#00 16#00\n"
        "08:21:14:677 RCV  16#02 16#56 16#02 16#02 16#10 16#92 16#00 16#00 16#00 16#02\n",
        SENT_AND_RECEIVED,
    ),
    "plc, both directions on a line": (
        "cycle 1  TX: 02 D7 03 03 00 03 10 03 04 07 00  RX:\n"
        "cycle 2  TX: 02 6C 00 00 00 92 00 00  RX: 02 56 02 02 10 92 00 00 00 02\n",
        MARKED,
    ),
    "c, python and basic": (
        "tx 0x02, 0xD7, 0x03, 0x03, 0x00, 0x03, 0x10, 0x03, 0x04, 0x07, 0x00\n"
        "tx b'\\x02\\x6C\\x00\\x00\\x00\\x92\\x00\\x00'\n"
        "rx &H02 &H56 &H02 &H02 &H10 &H92 &H00 &H00 &H00 &H02\n",
        MARKED,
    ),
    "brackets, colons, hyphens, h": (
        "> <02><D7><03><03><00><03><10><03><04><07><00>\n"
        "> 02:6C:00:00:00:92:00:00\n"
        "< 02h 56h 02h 02h 10h 92h 00h 00h 00h 02h\n",
        MARKED,
    ),
    "no leading zeros": ("2 D7 3 3 0 3 10 3 4 7 0\n2 6C 0 0 0 92 0 0\n2 56 2 2 10 92 0 0 0 2\n", NO_TIMES),
    "words around": (
        "05 Feb 2022 15:46:56.692 27212 [25748] trace Port - write 11 bytes <02D7030300031003040700> ok\n"
        "05 Feb 2022 15:46:56.792 27350 [25748] trace Port - write 8 bytes <026C000000920000> ok\n"
        "05 Feb 2022 15:46:56.828 27488 [25748] trace Port - read 10 bytes <02560202109200000002> ok\n",
        SENT_AND_RECEIVED,
    ),
    "a serial port monitor, functions above the bytes": (
        "[14/03/2013 08:21:14]\n"
        "12  IRP_MJ_WRITE - Request transfers data from a client to a COM port (COM5)\n"
        "   STATUS_SUCCESS\n"
        "      02 D7 03 03 00 03 10 03 04 07 00                          ...........\n"
        "[14/03/2013 08:21:14]\n"
        "13  IRP_MJ_WRITE - Request transfers data from a client to a COM port (COM5)\n"
        "   STATUS_SUCCESS\n"
        "      02 6C 00 00 00 92 00 00                                   .l......\n"
        "[14/03/2013 08:21:14]\n"
        "14  IRP_MJ_READ - Transfers data from a COM port to a client (COM5)\n"
        "   STATUS_SUCCESS\n"
        "      02 56 02 02 10 92 00 00 00 02                             .V........\n",
        [Expected(SET_RATE, SENT, 0), Expected(READ_PHASE, SENT, 0), Expected(PHASE, RECEIVED, 0)],
    ),
    "a serial port monitor, words above the bytes": (
        "[14/03/2013 08:21:14]  Written data (COM5)\n"
        "    02 D7 03 03 00 03 10 03 04 07 00      ...........\n"
        "[14/03/2013 08:21:14]  Written data (COM5)\n"
        "    02 6C 00 00 00 92 00 00               .l......\n"
        "[14/03/2013 08:21:14]  Read data (COM5)\n"
        "    02 56 02 02 10 92 00 00 00 02         .V........\n",
        [Expected(SET_RATE, SENT, 0), Expected(READ_PHASE, SENT, 0), Expected(PHASE, RECEIVED, 0)],
    ),
    "a serial port monitor, table with lengths": (
        '12,"14/03/2013 08:21:14.541","IRP_MJ_WRITE","DOWN","02 D7 03 03 00 03 10 03 04 07 00","..","11"\n'
        '13,"14/03/2013 08:21:14.641","IRP_MJ_WRITE","DOWN","02 6C 00 00 00 92 00 00",".l..","8"\n'
        '14,"14/03/2013 08:21:14.677","IRP_MJ_READ","UP","02 56 02 02 10 92 00 00 00 02",".V..","10"\n',
        SENT_AND_RECEIVED,
    ),
    "socat": (
        "> 2013/03/14 08:21:14.541000  length=11 from=0 to=10\n 02 d7 03 03 00 03 10 03 04 07 00  ...........\n--\n"
        "> 2013/03/14 08:21:14.641000  length=8 from=11 to=18\n 02 6c 00 00 00 92 00 00           .l......\n--\n"
        "< 2013/03/14 08:21:14.677000  length=10 from=0 to=9\n 02 56 02 02 10 92 00 00 00 02     .V........\n--\n",
        SENT_AND_RECEIVED,
    ),
    "pyserial, spy://": (
        "000000.541 TX   0000  02 D7 03 03 00 03 10 03  04 07 00                 ........ ...\n"
        "000000.641 TX   0000  02 6C 00 00 00 92 00 00                           .l......\n"
        "000000.677 RX   0000  02 56 02 02 10 92 00 00                           .V......\n"
        "000000.677 RX   0008  00 02                                             ..\n",
        SENT_AND_RECEIVED,
    ),
    "python, text as text": (
        "08:21:14,541 DEBUG send b'\\x02\\xd7\\x03\\x03\\x00\\x03\\x10\\x03\\x04\\x07\\x00'\n"
        "08:21:14,641 DEBUG send b'\\x02l\\x00\\x00\\x00\\x92\\x00\\x00'\n"
        "08:21:14,677 DEBUG recv b'\\x02'\n08:21:14,677 DEBUG recv b'V'\n"
        "08:21:14,677 DEBUG recv b'\\x02\\x02\\x10\\x92\\x00\\x00\\x00\\x02'\n",
        SENT_AND_RECEIVED,
    ),
    "strace": (
        '08:21:14.541000 write(3, "\\2\\327\\3\\3\\0\\3\\20\\3\\4\\7\\0", 11) = 11\n'
        '08:21:14.641000 write(3, "\\x02\\x6c\\x00\\x00\\x00\\x92\\x00\\x00", 8) = 8\n'
        '08:21:14.677000 read(3, "\\2V\\2\\2\\20\\222\\0\\0\\0\\2", 64) = 10\n',
        SENT_AND_RECEIVED,
    ),
    "decimal numbers": (
        "tx [2, 215, 3, 3, 0, 3, 16, 3, 4, 7, 0]\ntx [2, 108, 0, 0, 0, 146, 0, 0]\nrx [2, 86, 2, 2]\n"
        "rx [16, 146, 0, 0, 0, 2]\n",
        MARKED,
    ),
    "suffixes and lengths": (
        "(08:21:14.541) 02h D7h 03h 03h 00h 03h 10h 03h 04h 07h 00h (11)\n"
        "(08:21:14.641) 02h 6Ch 00h 00h 00h 92h 00h 00h (8)\n"
        "(08:21:14.677) 02h 56h 02h 02h 10h 92h 00h 00h 00h 02h (10)\n",
        _shared(0, 100, 136),
    ),
    "numbers of lines": (
        "9\t02 D7 03 03 00 03 10 03 04 07 00\n10\t02 6C 00 00 00 92 00\n11:00 02 56 02 02 10 92\n12:00 00 00 02\n",
        NO_TIMES,
    ),
    "lengths in a column": (
        "1,TX,11,02 D7 03 03 00 03 10 03 04 07 00\n2,TX,8,02 6C 00 00 00 92 00 00\n3,RX, 6 02 56 02 02 10 92\n"
        "4,RX[4]: 00 00 00 02\n",
        MARKED,
    ),
    "processes and threads": (
        "08:21:14.541 1234 5678 D drv [0x00001a2c] TX 02 D7 03 03 00 03 10 03 04 07 00\n"
        "08:21:14.641 1234 5678 D drv 00007ff6a1b2c3d4 TX 02 6C 00 00 00 92 00 00\n"
        "08:21:14.677 1234 5678 D drv [0x00001a2c] RX 02 56 02 02 10 92 00 00 00 02\n",
        SENT_AND_RECEIVED,
    ),
    "table, german": (
        "Zeit;Richtung;Daten\n14.03.2013 08:21:14,54;TX;02 D7 03 03 00 03 10 03 04 07 00\n"
        "14.03.2013 08:21:14,64 [TX] 02 6C 00 00 00 92 00 00\n"
        "14.03.2013 08:21:14,676;RX;02;56;02;02;10;92;00;00;00;02;;;\n",
        SENT_AND_RECEIVED,
    ),
    "marks in lines of their own": (
        "TX:\n02 D7 03 03 00 03 10 03 04 07 00\n02 6C 00 00 00 92 00 00\n"
        "Received 10 bytes\n02 56 02 02 10 92 00 00 00 02\n",
        MARKED,
    ),
    "xml": (
        '<t dir="out">02 D7 03 03 00 03 10 03 04 07 00</t>\n<t dir="out">02 6C 00 00 00 92 00 00</t>\n'
        '<t dir="in">02 56 02 02 10 92 00 00 00 02</t>\n',
        MARKED,
    ),
    "colours, other spaces": (
        "\x1b[32mTX 02 D7 03 03 00 03 10 03 04 07 00\x1b[0m\n"
        "\x1b[32mTX\xa002\xa06C\xa000\xa000\xa000\xa092\xa000\xa000\x1b[0m\n"
        "\x1b[31mRX\t02\t56\t02\t02\t10\t92\t00\t00\t00\t02\x1b[0m\n",
        MARKED,
    ),
    "basic": (
        "$02$D7$03$03$00$03$10$03$04$07$00\n$02$6C$00$00$00$92$00$00\n%02%56%02%02%10%92%00%00%00%02\n",
        NO_TIMES,
    ),
    "fifteen decimals": (
        "".join(f"0.541000000000000,0x{byte:02X},,\n" for byte in SET_RATE)
        + "".join(f"0.641000000000000,0x{byte:02X},,\n" for byte in READ_PHASE)
        + "".join(f"0.677000000000000,0x{byte:02X},,\n" for byte in PHASE),
        _shared(0, 100, 136),
    ),
    "docklight, settings": (
        "COM3: 9600,e,8,1\n02 D7 03 03 00 03 10 03 04 07 00\n02 6C 00 00 00 92 00 00\n02 56 02 02 10 92 00 00 00 02\n",
        NO_TIMES,
    ),
    "step 7, bytes": (
        "DB10\n"
        + "".join(f"DB10.DBB {place:4}   HEX   B#16#{byte:02X}\n" for place, byte in enumerate(SET_RATE + READ_PHASE))
        + "".join(f"  {place}.0  DATA[{place}]  BYTE  B#16#{byte:02X}\n" for place, byte in enumerate(PHASE)),
        NO_TIMES,
    ),
    "step 7, words": (
        "FETCH DB10 DW0\nDB10.DBW 0 HEX W#16#026C\nMW 2: W#16#0000\nW#16#0092\nW#16#0000\n"
        "SEND DB10\nDW#16#0256_0202 DW#16#1092_0000\nWORD#16#0002\n",
        [Expected(READ_PHASE), Expected(PHASE, SENT)],
    ),
    "step 7, words in a line": (
        "W#16#026C W#16#0000, W#16#0092 W#16#0000\nDB10 02 56 02 02 10 92 00 00 00 02\n",
        EVEN,
    ),
    "a byte a line, iec 61131": ("".join(f"16#{byte:X}\n" for byte in SET_RATE + READ_PHASE + PHASE), NO_TIMES),
    "s5, words": (
        "DB 10\n0:      KH = 026C;\n1:      KH = 0000;\n2:      KH = 0092;\n3:      KH = 0000;\n"
        "DW  4:  KH=0256\nDW  5:  KH=0202\nDW  6:  KH=1092 KH=0000\nDW  8:  KH 0002\n",
        EVEN,
    ),
    "tia portal": (
        "".join(
            f'"Frame".Data[{place}];%DB10.DBB{place};Hex;16#{byte:02X}\n'
            for place, byte in enumerate(SET_RATE + READ_PHASE)
        )
        + "10 16#0256\n11 16#0202\n12 16#1092\n13 16#0000\n14 16#0002\n",
        NO_TIMES,
    ),
    "tabs and columns": (
        "1\t0.541000\tout\t02 D7 03 03 00 03 10 03 04 07 00\n"
        "2\t0.641000\tout\t02 6C 00 00 00 92 00 00\n"
        "3\t0.677000\tin\t02 56 02 02 10 92 00 00 00 02\n",
        MARKED,
    ),
    # Forms that only the whole log tells: see choosing.py.
    "esp-idf, rows with a label": (
        "".join(
            f"I ({4541 + 100 * more}) uart: {data[start : start + 16].hex(' ')} \n"
            for more, data in enumerate(LISTS)
            for start in range(0, len(data), 16)
        ),
        [Expected(data) for data in LISTS],
    ),
    "rows with a label and a time": (
        "".join(
            f"Sep 25 10:06:0{more} /dev/ttyS0 --> message: {more} length: {len(data)} \n"
            + "".join(
                f"Sep 25 10:06:0{more} data:       {data[start : start + 16].hex(' ')} \n"
                for start in range(0, len(data), 16)
            )
            for more, data in enumerate(LISTS)
        ),
        [Expected(data, SHARED, 1000 * more) for more, data in enumerate(LISTS)],
    ),
    "esp-idf, a dump with addresses in memory": (
        "D (4541) app: 0x3f40b3cc   02 d7 03 03 00 03 10 03  04 07 00  |...........|\n"
        "D (4641) app: 0x3f40b3cc   02 6c 00 00 00 92 00 00    |.l......|\n"
        "D (4677) app: 0x3f40b3cc   02 56 02 02 10 92 00 00  00 02  |.V........|\n",
        NO_TIMES,
    ),
    "esp-idf, letters of levels": (
        "I (4541) m: 02 d7 03 03 00 03 10 03\nW (4541) m: 04 07 00 02 6c 00 00 00\n"
        "I (4577) m: 92 00 00 02 56 02 02 10 92 00 00 00 02\n",
        NO_TIMES,
    ),
    "qmodmaster": (
        "[RTU]>Tx > 08:21:14:541 - 02  D7  03  03  00  03  10  03  04  07  00  \n"
        "[RTU]>Tx > 08:21:14:641 - 02  6C  00  00  00  92  00  00  \n"
        "[RTU]>Rx > 08:21:14:677 - 02  56  02  02  10  92  00  00  00  02  \n",
        SENT_AND_RECEIVED,
    ),
    "modbus_tk, dashes": (
        "2013-03-14 08:21:14,541 DEBUG modbus_tk -> 2-215-3-3-0-3-16-3-4-7-0\n"
        "2013-03-14 08:21:14,641 DEBUG modbus_tk -> 2-108-0-0-0-146-0-0\n"
        "2013-03-14 08:21:14,677 DEBUG modbus_tk <- 2-86-2-2-16-146-0-0-0-2\n",
        SENT_AND_RECEIVED,
    ),
    "java, signed": (
        "TX [2, -41, 3, 3, 0, 3, 16, 3, 4, 7, 0]\nTX [2, 108, 0, 0, 0, -110, 0, 0]\n"
        "RX [2, 86, 2, 2, 16, -110, 0, 0, 0, 2]\n",
        MARKED,
    ),
    "json, a number a line": (
        "".join(
            f'{{\n  "dir": "{mark}",\n  "data": [\n    ' + ",\n    ".join(map(str, data)) + "\n  ]\n}\n"
            for mark, data in (("tx", SET_RATE), ("tx", READ_PHASE), ("rx", PHASE))
        ),
        MARKED,
    ),
    "json, escapes": (
        '{"dir":"tx","data":"\\u0002\\u00d7\\u0003\\u0003\\u0000\\u0003\\u0010\\u0003\\u0004\\u0007\\u0000"}\n'
        '{"dir":"tx","data":"\\u0002l\\u0000\\u0000\\u0000\\u0092\\u0000\\u0000"}\n'
        '{"dir":"rx","data":"\\u0002V\\u0002\\u0002\\u0010\\u0092\\u0000\\u0000\\u0000\\u0002"}\n',
        MARKED,
    ),
    "node, lists over several lines": (
        "TX [\n  2, 215, 3, 3,\n  0, 3, 16, 3,\n  4, 7, 0\n]\nTX [\n  2, 108, 0, 0,\n  0, 146, 0, 0\n]\n"
        "RX [\n  2, 86, 2, 2,\n  16, 146, 0, 0,\n  0, 2\n]\n",
        MARKED,
    ),
    "python, hexlify": (
        "TX b'02d7030300031003040700'\nTX b'026c000000920000'\nRX b'02560202109200000002'\n",
        MARKED,
    ),
    "labview": (
        '14.03.2013 08:21:14.541\tWrite\t"\\02\\D7\\03\\03\\00\\03\\10\\03\\04\\07\\00"\n'
        '14.03.2013 08:21:14.641\tWrite\t"\\02l\\00\\00\\00\\92\\00\\00"\n'
        '14.03.2013 08:21:14.677\tRead\t"\\02V\\02\\02\\10\\92\\00\\00\\00\\02"\n',
        SENT_AND_RECEIVED,
    ),
    "codesys": (
        "TX '$02$D7$03$03$00$03$10$03$04$07$00'\nTX '$02l$00$00$00$92$00$00'\nRX '$02V$02$02$10$92$00$00$00$02'\n",
        MARKED,
    ),
    "delphi": (
        "TX #2#215#3#3#0#3#16#3#4#7#0\nTX #2'l'#0#0#0#146#0#0\nRX #2'V'#2#2#16#146#0#0#0#2\n",
        MARKED,
    ),
    "cutecom, control characters": (
        "[08:21:14.541] <0x02><0xd7><0x03><0x03><0x00><0x03><0x10><0x03><0x04><0x07><0x00>\n"
        "[08:21:14.641] <0x02>l<0x00><0x00><0x00><0x92><0x00><0x00>\n"
        "[08:21:14.677] <0x02>\n[08:21:14.678] V\n[08:21:14.679] <0x02><0x02><0x10><0x92><0x00><0x00><0x00><0x02>\n",
        _shared(0, 100, 136),
    ),
    "both directions in a line, behind words": (
        "2024-04-13 18:15:13.559 ERROR: request ask for id=1 but got id=127, Skipping. "
        + ">>>>> send: 0x2 0x6c 0x0 0x0 0x0 0x92 0x0 0x0 "
        ">>>>> recv: 0x2 0x56 0x2 0x2 0x10 0x92 0x0 0x0 0x0 0x2 extra data: " * 2 + "\n",
        [Expected(READ_PHASE, SENT, 0), Expected(PHASE, RECEIVED, 0)] * 2,
    ),
    "sigrok, a byte a line": ("".join(f"uart-1: {byte:02X}\n" for byte in SET_RATE + READ_PHASE + PHASE), NO_TIMES),
    "dsview": (
        "Id,Time[ns],0:UART: RX/TX\n"
        + "".join(
            f"{place},{541 + place}000000.00,{byte:02X}\n" for place, byte in enumerate(SET_RATE + READ_PHASE + PHASE)
        ),
        NO_TIMES,
    ),
    "hhd, requests and answers": (
        'Port opened by process "drive.exe" (PID: 1234)\n\n'
        "Request: 3/14/2013 4:30:30 PM.34364 (+0.0000 seconds)\n\n 02 D7 03 03 00 03 10 03 04 07 00   ...........\n\n"
        "Request: 3/14/2013 4:30:30 PM.44364 (+0.0000 seconds)\n\n 02 6C 00 00 00 92 00 00            .l......\n\n"
        "Answer: 3/14/2013 4:30:30 PM.47964 (+0.0360 seconds)\n\n 02 56 02 02 10 92 00 00 00 02      .V........\n\n",
        SENT_AND_RECEIVED,
    ),
    "eltima, a table with both ways of a request": (
        "1 14/03/2013 08:21:14 IRP_MJ_WRITE DOWN  02 d7 03 03 00 03 10 03 04 07 00  ........... 11 11 COM4  \n"
        "2 14/03/2013 08:21:14 IRP_MJ_WRITE UP STATUS_SUCCESS 02 d7 03 03 00 03 10 03 04 07 00  ........... 11\n"
        "3 14/03/2013 08:21:15 IRP_MJ_WRITE DOWN  02 6c 00 00 00 92 00 00  .l...... 8 8 COM4  \n"
        "4 14/03/2013 08:21:15 IRP_MJ_WRITE UP STATUS_SUCCESS 02 6c 00 00 00 92 00 00  .l...... 8  COM4  \n"
        "5 14/03/2013 08:21:16 IRP_MJ_READ UP STATUS_SUCCESS 02 56 02 02 10 92 00 00 00 02  .V...?.... 10  COM4  \n",
        [Expected(SET_RATE, SENT, 0), Expected(READ_PHASE, SENT, 1000), Expected(PHASE, RECEIVED, 2000)],
    ),
    "logfmt": (
        'time=2013-03-14T08:21:14.541Z level=D dir=tx data="\\x02\\xd7\\x03\\x03\\x00\\x03\\x10\\x03\\x04\\a\\x00"\n'
        'time=2013-03-14T08:21:14.641Z level=D dir=tx data="\\x02l\\x00\\x00\\x00\\x92\\x00\\x00"\n'
        'time=2013-03-14T08:21:14.677Z level=D dir=rx data="\\x02V\\x02\\x02\\x10\\x92\\x00\\x00\\x00\\x02"\n',
        SENT_AND_RECEIVED,
    ),
    "influx, ns behind the bytes": (
        'sis,port=ttyUSB0,dir=tx data="02d7030300031003040700",len=11i 1363249274541000000\n'
        'sis,port=ttyUSB0,dir=tx data="026c000000920000",len=8i 1363249274641000000\n'
        'sis,port=ttyUSB0,dir=rx data="02560202109200000002",len=10i 1363249274677000000\n',
        SENT_AND_RECEIVED,
    ),
    "a data base": (
        "  id  |           ts            | dir |           data\n"
        " 4711 | 2013-03-14 08:21:14.541 | tx  | \\x02d7030300031003040700\n"
        " 4712 | 2013-03-14 08:21:14.641 | tx  | \\x026c000000920000\n"
        " 4713 | 2013-03-14 08:21:14.677 | rx  | \\x02560202109200000002\n",
        SENT_AND_RECEIVED,
    ),
    "qt, words that are joined": (
        '08:21:14.541 default: write "\\x02\\xD7\\x03\\x03\\x00\\x03\\x10\\x03\\x04\\x07\\x00"\n'
        '08:21:14.641 default: write "\\x02l\\x00\\x00\\x00\\x92\\x00\\x00"\n'
        '08:21:14.677 default: readyRead "\\x02V\\x02\\x02\\x10\\x92\\x00\\x00\\x00\\x02"\n',
        SENT_AND_RECEIVED,
    ),
    "words in a heading directly above the bytes": (
        "000017: Write Request (DOWN), 2013-03-14 08:21:14.5410000 +0 (1. Device: USB Serial Port (COM3))\n"
        " 02 D7 03 03 00 03 10 03 04 07 00   ...........\n\n"
        "000018: Write Request (UP), 2013-03-14 08:21:14.5420000 +0.001 (1. Device: USB Serial Port (COM3))\n\n"
        "000019: Write Request (DOWN), 2013-03-14 08:21:14.6410000 +0.099 (1. Device: USB Serial Port (COM3))\n"
        " 02 6C 00 00 00 92 00 00            .l......\n\n"
        "000020: Read Request (UP), 2013-03-14 08:21:14.6770000 +0.036 (1. Device: USB Serial Port (COM3))\n"
        " 02 56 02 02 10 92 00 00 00 02      .V........\n",
        SENT_AND_RECEIVED,
    ),
    "zephyr": (
        "[00:01:16.541,000] <dbg> sis_uart: tx telegram\n    02 d7 03 03 00 03 10 03  04 07 00    |........ ...\n"
        "[00:01:16.641,000] <dbg> sis_uart: tx telegram\n    02 6c 00 00 00 92 00 00              |.l......\n"
        "[00:01:16.677,000] <dbg> sis_uart: rx telegram\n    02 56 02 02 10 92 00 00  00 02       |.V...... ..\n",
        SENT_AND_RECEIVED,
    ),
    "xxd -b": (
        "00000000: 00000010 01101100 00000000 00000000 00000000 10010010  .l....\n"
        "00000006: 00000000 00000000 00000010 01010110 00000010 00000010  ...V..\n"
        "0000000c: 00010000 10010010 00000000 00000000 00000000 00000010  ......\n",
        EVEN,
    ),
    "hexdump, words": (
        "0000000 6c02 0000 9200 0000 5602 0202 9210 0000\n0000010 0200\n0000012\n",
        EVEN,
    ),
    "od -c": (
        "0000000 002   l  \\0  \\0  \\0 222  \\0  \\0 002   V 002 002 020 222  \\0  \\0\n0000020  \\0 002\n0000022\n",
        EVEN,
    ),
    "xxd, the column of a short row": (
        "00000000: 02d7 0303 0003 1003 0407 0002 6c00 0000  ............l...\n"
        "00000010: 9200 0002 5602 0210 9200 0000            ....V.......\n"
        "0000001c: 02                                       .\n",
        NO_TIMES,
    ),
    "portsniffer": (
        "".join(
            f"{mark} |    1 | {byte:02X}\n"
            for mark, data in (("W", SET_RATE), ("W", READ_PHASE), ("R", PHASE))
            for byte in data
        ),
        MARKED,
    ),
    "serialtool, bars": (
        "28/12/2022@22:43:10.829::Packet[00000001l]>>Serial [1] [[COM5] - USB Serial Port] Sent 11 bytes.\n"
        "02|D7|03|03|00|03|10|03|04|07|00| | | | | || . . . . . . . . . . .\n"
        "28/12/2022@22:43:10.929::Packet[00000002l]>>Serial [1] [[COM5] - USB Serial Port] Sent 8 bytes.\n"
        "02|6C|00|00|00|92|00|00| | | | | | | | || . l . . . . . .\n"
        "28/12/2022@22:43:10.965::Packet[00000003l]<<Serial [1] [[COM5] - USB Serial Port] Received 10 bytes.\n"
        "02|56|02|02|10|92|00|00|00|02| | | | | | || . V . . . . . . . .\n",
        SENT_AND_RECEIVED,
    ),
    "matlab": (
        "tx =\n\n     2   108     0     0     0   146     0     0\n\n"
        "rx =\n\n     2    86     2     2    16   146     0     0     0     2\n",
        MARKED[1:],
    ),
    "a table, a decimal number a line": (
        "time,value\n" + "".join(f"0.{541 + place},{byte}\n" for place, byte in enumerate(READ_PHASE + PHASE)),
        [Expected(READ_PHASE, SHARED, 0), Expected(PHASE, SHARED, 8)],
    ),
    "underscores": ("".join(f"{one.hex('_').upper()}\n" for one in (SET_RATE, READ_PHASE, PHASE)), NO_TIMES),
    "full-width characters": (
        "０２ ６Ｃ ００ ００ ００ ９２ ００ ００\n０２　５６　０２　０２　１０　９２　００　００　００　０２\n",
        EVEN,
    ),
    "names of control characters": (
        "STX D7 ETX ETX NUL ETX DLE ETX EOT 07 NUL\n<STX> 6C <NUL> <NUL> <NUL> 92 <NUL> <NUL>\n"
        "stx 56 stx stx dle 92 nul nul nul stx\n",
        NO_TIMES,
    ),
    "base64": (f"{b64encode(SET_RATE).decode()}\n{b64encode(READ_PHASE + PHASE).decode()}\n", NO_TIMES),
    "base64 in JSON, without an end": (
        "".join(
            f'{{"topic": "SomeTelegram/drive", "payload": "{urlsafe_b64encode(one).decode().rstrip("=")}"}}\n'
            for one in (SET_RATE, READ_PHASE, PHASE)
        ),
        NO_TIMES,
    ),
}
