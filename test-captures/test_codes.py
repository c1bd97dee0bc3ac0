# SPDX-License-Identifier: GPL-2.0-or-later
"""Every code and its text: tables written by hand from the documents, compared with codes.toml and tshark's output.

Figures and chapters are those of the SIS definition, DOK-GENERL-SIS-DEFINIT-IF02.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
from description import Description

from sistap.dissected.wireshark.tshark import Tshark

HERE = Path(__file__).parent
DESCRIBED = Description().tables


class Packet(NamedTuple):
    """A telegram in which a code stands."""

    service: int
    status: int
    codes: list[tuple[str, int, str]]  # field without its "sis.", value, what tshark writes


class Table(NamedTuple):
    """A table of a document, and the place where tshark shows its codes."""

    name: str  # in codes.toml; "" where the text is made elsewhere
    size: int  # codes, or ranges of codes, that the documents print
    field: str
    label: str
    texts: dict[int, str]
    shown: set[int] | None = None  # codes in the capture; None: all
    where: Callable[[Packet], bool] = lambda packet: True
    capture: str = "codes"
    edition: str = "IF02"
    advice: dict[int, str] = {}  # what tshark writes behind the label of a code


def label_of(table: Table, code: int) -> str:
    """Return what tshark writes for a code."""
    label = table.label.format(code=code, text=table.texts.get(code))
    return f"{label}: {table.advice[code]}" if code in table.advice else label


def ranges(*rows: tuple[int, int, str]) -> dict[int, str]:
    """Return the text of each code of the ranges; the first row that fits applies."""
    texts: dict[int, str] = {}
    for first, last, text in rows:
        for code in range(first, last + 1):
            texts.setdefault(code, text)
    return texts


PARAMETER_SERVICES = {group | low for group in (0x10, 0x80, 0x90) for low in (0x0, 0x1, 0xE, 0xF)}
PHASE_SERVICES = {0x12, 0x1D, 0x92, 0x9D}


def after(services: set[int], status: int) -> Callable[[Packet], bool]:
    """Tell for a reaction of these services with this status."""
    return lambda packet: packet.service in services and packet.status == status


# Fig. 2-9; those of the product groups from chapter 8 and the example telegrams.
SERVICES = (
    (0x00, 0x00, "Node identification"),
    (0x01, 0x01, "Cancel data transmission"),
    (0x02, 0x02, "Flash operation"),
    (0x03, 0x03, "Initialization of the SIS communication"),
    (0x04, 0x04, "Execute a list of SIS services"),
    (0x0F, 0x0F, "Token passing"),
    (0x10, 0x10, "Read parameter"),
    (0x11, 0x11, "Read list segment"),
    (0x12, 0x12, "Read phase"),
    (0x1D, 0x1D, "Switch phase"),
    (0x1E, 0x1E, "Write list segment"),
    (0x1F, 0x1F, "Write parameter"),
    (0x80, 0x80, "Read parameter (ECODRIVE)"),
    (0x81, 0x81, "Read list segment (ECODRIVE)"),
    (0x8E, 0x8E, "Write list segment (ECODRIVE)"),
    (0x8F, 0x8F, "Write parameter (ECODRIVE)"),
    (0x90, 0x90, "Read parameter (SYNAX)"),
    (0x91, 0x91, "Read list segment (SYNAX)"),
    (0x92, 0x92, "Read phase (SYNAX)"),
    (0x9D, 0x9D, "Switch phase (SYNAX)"),
    (0x9E, 0x9E, "Write list segment (SYNAX)"),
    (0x9F, 0x9F, "Write parameter (SYNAX)"),
    (0x05, 0x0E, "General service"),
    (0x13, 0x1C, "Reserved service"),
    (0x20, 0x7F, "Reserved service"),
    (0x82, 0x8D, "ECODRIVE service"),
    (0x93, 0x9C, "SYNAX service"),
    (0xA0, 0xAF, "MT-CNC/MTC200 service"),
    (0xB0, 0xBF, "ISP200 service"),
    (0xC0, 0xCF, "CLC-GPS service"),
    (0xD0, 0xDF, "HMI system service"),
    (0xE0, 0xEF, "DISC service"),
    (0xF0, 0xFF, "Reserved service"),
)

# Fig. 2-18, of which 0x03 to 0xEF are in fig. 8-4 only; IndraDrive: 0xF9 to 0xFC.
STATUS = (
    (0x00, 0x00, "Transmission error-free"),
    (0x01, 0x01, "Execution error"),
    (0x02, 0x02, "Error in the internal transmission channel"),
    (0x03, 0xEF, "Execution error, not specified"),
    (0xF0, 0xF0, "Invalid service"),
    (0xF1, 0xF1, "Invalid telegram"),
    (0xF2, 0xF2, "Wrong telegram length"),
    (0xF4, 0xF4, "Wrong checksum"),
    (0xF8, 0xF8, "Invalid sequential telegram"),
    (0xF9, 0xF9, "Command has subaddresses, the slave does not route"),
    (0xFA, 0xFA, "Useful data missing in the command"),
    (0xFB, 0xFB, "Subservice not supported"),
    (0xFC, 0xFC, "Component not available or address invalid"),
    (0xF3, 0xFF, "Telegram error, not specified"),
)

# Fig. 8-48. IDN: ident number; Datum: the operating data.
PARAMETER_ERRORS = {
    0x0000: "No error",
    0x0001: "Service channel not open",
    0x0009: "Wrong access to element 0",
    0x1001: "Ident number not available",
    0x1009: "Wrong access to element 1",
    0x2001: "Name not available",
    0x2002: "Name transmitted too short",
    0x2003: "Name transmitted too long",
    0x2004: "Name cannot be changed",
    0x2005: "Name is write-protected at present",
    0x3002: "Attribute transmitted too short",
    0x3003: "Attribute transmitted too long",
    0x3004: "Attribute cannot be changed",
    0x3005: "Attribute is write-protected at present",
    0x4001: "Unit not available",
    0x4002: "Unit transmitted too short",
    0x4003: "Unit transmitted too long",
    0x4004: "Unit cannot be changed",
    0x4005: "Unit is write-protected at present",
    0x5001: "Minimum not available",
    0x5002: "Minimum transmitted too short",
    0x5003: "Minimum transmitted too long",
    0x5004: "Minimum cannot be changed",
    0x5005: "Minimum is write-protected at present",
    0x6001: "Maximum not available",
    0x6002: "Maximum transmitted too short",
    0x6003: "Maximum transmitted too long",
    0x6004: "Maximum cannot be changed",
    0x6005: "Maximum is write-protected at present",
    0x7002: "Operating data transmitted too short",
    0x7003: "Operating data transmitted too long",
    0x7004: "Operating data cannot be changed",
    0x7005: "Operating data are write-protected at present",
    0x7006: "Operating data smaller than the minimum",
    0x7007: "Operating data greater than the maximum",
    0x7008: "Operating data not correct",
    0x700C: "Operating data outside the range: below zero, or above the modulo value of a modulo axis",
    0x700D: "The length of the operating data cannot be changed at present",
    0x700E: "The length of the operating data cannot be changed",
    0x700F: "List element not available, or the list offset is not the start of an element",
    0x8001: "Service channel busy",
}
SYNAX_AND_INDRADRIVE_ERRORS = {
    0x00A0: "Request not allowed",
    0x00B0: "Element not allowed",
    0x8002: "Failure in the service channel",
    0x800B: "Transmission cancelled, another request had priority",
    0x800C: "Service channel still active, or parameter occupied by a sequential transmission",
}

FLASH_ERRORS = {
    0x9002: "Firmware was deleted",
    0x9003: "Shutdown not allowed in phase 3",
    0x9004: "Shutdown not allowed in phase 4",
    0x9102: "Firmware was deleted",
    0x9103: "Reboot not allowed in phase 3",
    0x9104: "Reboot not allowed in phase 4",
    0x9200: "Read error",
    0x9400: "Timeout while erasing",
    0x940A: "Erasing is only possible in the loader",
    0x96FF: "Error while writing to the RAM",
    0x96E0: "Verify error while programming the flash",
    0x96E1: "Timeout while programming the flash",
    0x9701: "Additive checksum wrong",
    0x9702: "CRC32 checksum wrong",
}
INDRADRIVE_FLASH_ERRORS = {
    0x9010: "Shutdown not allowed in operating mode",
    0x9110: "Reboot not allowed in operating mode",
    0x920B: "More than the maximum of useful data",
}

BOUNDS = {0, 126, 127, 128, 129, 199, 200, 253, 254, 255}

# fmt: off
TABLES = [
    Table("services", 33, "service", "Service: {text} (0x{code:02x})", ranges(*SERVICES),
          {code for first, last, _ in SERVICES for code in (first, last)}),
    Table("status", 14, "status", "Status: {text} (0x{code:02x})", ranges(*STATUS),
          {0x00, 0x01, 0x02, 0x03, 0xEF, *range(0xF0, 0xF6), *range(0xF7, 0xFE), 0xFF},
          lambda packet: packet.service not in PHASE_SERVICES),
    Table("status_phase", 2, "status", "Status: {text} (0x{code:02x})",  # fig. 8-5
          {0x01: "Execution error, not specified for this service", 0x02: "Phase switching error"},
          where=lambda packet: packet.service in PHASE_SERVICES and packet.status in (1, 2)),
    Table("errors_channel", 4, "error", "Error code: {text} (0x{code:04x})",  # fig. 2-19
          {0x8001: "Transmission channel busy",
           0x8002: "Fault in the transmission channel",
           0x800B: "Transmission cancelled, another request had priority",
           0x800C: "Access not allowed, the transmission channel is still active"},
          where=lambda packet: packet.service not in PHASE_SERVICES and packet.status == 2,
          advice={0x8001: "repeat the command until the channel is free",
                  0x8002: "repeat the command to see whether the fault lasts",
                  0x800B: "repeat the command until it is executed without being cancelled",
                  0x800C: "repeat the command until the active request has ended"}),
    Table("errors_parameter", 41 + 5, "error", "Error code: {text} (0x{code:04x})",  # fig. 8-48
          PARAMETER_ERRORS | SYNAX_AND_INDRADRIVE_ERRORS, where=after(PARAMETER_SERVICES, 1),
          advice={0x8001: "not done within the time-out, which C-0-0124 sets; nothing was transferred"}),
    Table("errors_phase", 4, "error", "Error code: {text} (0x{code:04x})",  # fig. 8-49
          {0x8004: "Wrong phase requested over the serial protocol",
           0xD005: "Phase switch still active",
           0xD006: "Phase switch not allowed while a drive is enabled",
           0xD007: "Phase switch not allowed while the master axis turns"},
          where=after(PHASE_SERVICES, 2)),
    Table("errors_flash", 14 + 3, "error", "Error code: {text} (0x{code:04x})",  # chapter 5.3
          FLASH_ERRORS | INDRADRIVE_FLASH_ERRORS, where=after({0x02}, 1)),
    Table("errors_initialization", 3, "error", "Error code: {text} (0x{code:04x})",  # chapter 6.3
          {0x0700: "Baud rate not supported",
           0x0800: "Baud rate not supported",
           0x0801: "Test time too large for the internal timer"},
          where=after({0x03}, 1)),
    Table("subservices_identification", 4, "subservice", "Subservice: {text} (0x{code:02x})",  # fig. 3-12
          {0x01: "SIS version", 0x02: "Firmware (FWA) number", 0x03: "Device type key", 0x04: "Supported baud rates"},
          where=lambda packet: packet.service in (0x00, 0x04)),
    Table("subservices_flash", 8, "subservice", "Subservice: {text} (0x{code:02x})",  # fig. 5-27
          {0x90: "Shutdown", 0x91: "Reboot", 0x92: "Read flash", 0x93: "Find header", 0x94: "Erase flash",
           0x96: "Program flash", 0x97: "Build checksum", 0x9F: "Reset errors in the slave"},
          where=lambda packet: packet.service == 0x02),
    Table("subservices_initialization", 7, "subservice", "Subservice: {text} (0x{code:02x})",  # fig. 6-25
          {0x01: "Set TrS (slave reaction time)", 0x02: "Set TzA (character interval)",
           0x03: "Set Tmas (master control word cycle)", 0x06: "Assign multicast group", 0x07: "Set baud rate",
           0x08: "Timed baud rate test", 0xFF: "Accept the set values"},
          where=lambda packet: packet.service == 0x03),
    Table("shutdown_targets", 2, "flash.target", "Target: {text} (0x{code:02x})", {0: "Firmware", 1: "Loader"}),
    Table("device_types", 5, "flash.device_type", "Device type: {text} (0x{code:02x})",
          {0: "None (not supported)", 1: "ROM (not supported)", 2: "RAM", 3: "Dual-port RAM", 4: "Flash"}),
    Table("baud_masks", 5, "init.baud_mask", "Baud rate mask: 0x{code:02x} ({text})",  # fig. 6-11, 6-17
          {0x00: "9600", 0x01: "19200", 0x02: "38400", 0x04: "57600", 0x08: "115200"},
          where=lambda packet: packet.service == 0x03),
    Table("", 6, "init.baud_mask", "Baud rate mask: 0x{code:02x} ({text})",  # fig. 3-10: ORed, 9600 always supported
          {0x00: "9600", 0x01: "9600, 19200", 0x02: "9600, 38400", 0x04: "9600, 57600", 0x08: "9600, 115200",
           0x0F: "9600, 19200, 38400, 57600, 115200"},
          where=lambda packet: packet.service in (0x00, 0x04)),
    Table("elements", 8, "element", "Element: {text} ({code})",  # fig. 8-1
          {0: "Channel not active", 1: "Ident number", 2: "Name", 3: "Attribute", 4: "Unit", 5: "Minimum",
           6: "Maximum", 7: "Operating data"}),
    Table("", 3, "parameter.type", "Type: {text} ({code})",  # fig. 8-3
          {0: "Parameter of a drive", 1: "Control parameter, first kind (A)", 2: "Control parameter, second kind (C)"}),
    Table("phases", 2, "phase", "Phase: {code} ({text})", {2: "parameter mode", 4: "operating mode"},
          where=lambda packet: all(code in (2, 4) for field, code, _ in packet.codes if field == "phase")),
    Table("", 3, "phase", "Phase: {code}", dict.fromkeys((0, 1, 3), ""),
          where=lambda packet: all(code not in (2, 4) for field, code, _ in packet.codes if field == "phase")),
    Table("", 7, "data_status", "Data status: 0x{code:04x} (command {text})",  # fig. 8-44
          {0x0000: "not set", 0x0003: "done", 0x0005: "interrupted", 0x0007: "in process",
           0x000F: "execution not possible", 0x0100: "not set, operating data invalid",
           0x0103: "done, operating data invalid"}),
    Table("", 8, "attribute.length", "Length: {text} ({code})",
          {0: "Not defined", 1: "2 bytes", 2: "4 bytes", 3: "8 bytes", 4: "List of single bytes",
           5: "List of 2-byte elements", 6: "List of 4-byte elements", 7: "List of 8-byte elements"}),
    Table("", 8, "attribute.format", "Format: {text} ({code})",
          {0: "Binary", 1: "Unsigned decimal", 2: "Signed decimal", 3: "Hexadecimal", 4: "Text", 5: "Ident number",
           6: "Floating point", 7: "Time"}),
    Table("", 7, "receiver", "Receiver address: {code} ({text})",
          ranges((0, 126, "station"), (127, 127, "not assigned"), (128, 128, "point-to-point"), (129, 199, "reserved"),
                 (200, 253, "logical group"), (254, 254, "broadcast on one hierarchy level"),
                 (255, 255, "global broadcast")), BOUNDS),
    Table("", 3, "sender", "Sender address: {code} ({text})",
          ranges((0, 126, "station"), (127, 127, "service or emergency master"), (128, 255, "not a sender address")),
          {0, 126, 127, 128, 255}),
    Table("", 3, "receiver", "Receiver address: {code} ({text})",
          ranges((0, 127, "station"), (128, 254, "logical group"), (255, 255, "global broadcast")), BOUNDS,
          edition="ECODRIVE03"),
    Table("", 2, "sender", "Sender address: {code} ({text})",
          ranges((0, 127, "station"), (128, 255, "not a sender address")), {0, 126, 127, 128, 255},
          edition="ECODRIVE03"),
    Table("control_status_ecodrive03", 8, "control.status", "Status: {text} ({code})",
          {0: "No error, request processed", 1: "Request still being processed", 2: "Request cannot be processed now",
           3: "Not defined", 4: "Warning", 5: "Not defined", 6: "Error", 7: "Not defined"},
          {0, 1, 2, 4, 6, 7}, capture="ecodrive03", edition="ECODRIVE03"),
]
# fmt: on

every_table = pytest.mark.parametrize("table", TABLES, ids=lambda table: f"{table.name or table.field}-{table.edition}")


def described(name: str) -> dict[int, str]:
    """Return a table of the description."""
    return ranges(*((code.first, code.last, code.text) for code in DESCRIBED[name].codes))


@cache
def packets(tshark: Tshark, capture: str, edition: str) -> list[Packet]:
    """Dissect a capture."""
    options = ("-r", str(HERE / f"{capture}.pcapng"), "-o", f"sis.edition:{edition}", "-T", "pdml")
    found = []
    for packet in ElementTree.fromstring(tshark.output(*options)):
        fields = [
            (element.get("name", "").removeprefix("sis."), element.get("show", ""), element.get("showname", ""))
            for element in packet.iter("field")
        ]
        first = {name: show for name, show, _ in reversed(fields)}
        wanted = {table.field for table in TABLES}
        codes = [
            (name, int(show, 0), showname.rpartition(" = ")[2]) for name, show, showname in fields if name in wanted
        ]
        found.append(Packet(int(first["service"], 0), int(first.get("status", "0"), 0), codes))
    return found


@every_table
def test_the_document_has_as_many(table: Table) -> None:
    """A slip in the tables above shows here."""
    by_range = {"services": len(SERVICES), "status": len(STATUS)}
    is_address = table.field in ("sender", "receiver")
    size = len(set(table.texts.values())) if is_address else by_range.get(table.name, len(table.texts))
    assert size == table.size


@pytest.mark.parametrize("table", [table for table in TABLES if table.name], ids=lambda table: table.name)
def test_source(table: Table) -> None:
    assert described(table.name) == table.texts


def test_data_states() -> None:
    """Their bits 0 to 3 alone (fig. 8-44)."""
    states = {0x0: "not set", 0x3: "done", 0x5: "interrupted", 0x7: "in process", 0xF: "execution not possible"}
    assert described("data_states") == states


@every_table
def test_tshark(table: Table, tshark: Tshark) -> None:
    labels = {
        (code, label)
        for packet in packets(tshark, table.capture, table.edition)
        if table.where(packet)
        for field, code, label in packet.codes
        if field == table.field
    }
    shown = table.texts.keys() if table.shown is None else table.shown
    assert {code for code, _ in labels} >= shown, "not in the capture"
    assert labels == {(code, label_of(table, code)) for code, _ in labels}


def test_severity_of_a_status(tshark: Tshark) -> None:
    """Fig. 8-4: 0x01 to 0xEF are execution errors, 0xF0 to 0xFF telegram errors."""
    names = ("status", "status.execution_error", "status.telegram_error")
    options = [option for name in names for option in ("-e", f"sis.{name}")]
    output = tshark.output("-r", str(HERE / "codes.pcapng"), "-Y", "sis.status", "-T", "fields", *options)
    seen = set()
    for line in output.splitlines():
        status, execution, telegram = line.split("\t")
        code = int(status.split(",")[0], 0)
        seen.add(code)
        assert (bool(execution), bool(telegram)) == (0x01 <= code <= 0xEF, code >= 0xF0), status
    assert seen >= {0x00, 0x01, 0x02, 0x03, 0xEF, 0xF0, 0xFF}
