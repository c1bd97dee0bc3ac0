# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes stations from tables, such as the [[station]] tables of a scenario. Their keys are in sets/README.md."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from sisbus.devices.equipment import ECODRIVE, INDRADRIVE, DriveModel, Equipment
from sisbus.service import Service, by_layout
from sisbus.stations.flash import Flash, Memory
from sisbus.stations.general import LIST, LONGEST_TEXT, cancel, identification, service_list
from sisbus.stations.initialization import Initialization
from sisbus.stations.sercos import OF_DRIVES, Parameters, Segments
from sisbus.stations.station import EDITIONS, Edition, Station
from sisbus.stations.terminal import Terminal
from sisbus.table import BYTE, STATION, Table, ascii_text, choice, flag, several, tables, whole
from sistap.tap.sis.codes import LAYOUTS
from sistap.tap.sis.rates import BAUD_MASKS, RATES

_GENERAL = 0x10  # the group of services that every station has
_DRIVES = 0x80
_LOADER_SERVICES = range(0x04)  # services available without firmware
_NOTHING: Mapping[int, int] = {}


class _Kind(NamedTuple):
    """A kind of station."""

    type_key: str
    firmware: str
    group: int  # the services of its product group, besides the general ones
    model: DriveModel | None = None  # a drive; without it a control
    synax: bool = False
    edition: str = "IF02"  # unless the table says another


_KINDS = {
    "drive": _Kind("DKC02.3-040-7-FW", "FWA-ECODR3-SMT-02VRS-MS", _DRIVES, ECODRIVE),
    "indradrive": _Kind(
        "HCS02.1E-W0028-A-03-NNNN", "FWA-INDRV*-MPH-02VRS-D5", _DRIVES, INDRADRIVE, edition="IndraDrive"
    ),
    "clc": _Kind("CLC-D02.3M-FW", "FWA-CLC*DP-SY*-06VRS-MS", _GENERAL),
    "synax": _Kind("PPC-R01.2N-N-SS", "FWA-PPC*RS-SY*-08VRS-MS", 0x90, synax=True),
}


def make(tables: Sequence[Mapping[str, object]], seed: int) -> list[Station]:
    """Return the stations of one level. ValueError is one line with the key and the cure."""
    return _level([Table(content, f"station {place}") for place, content in enumerate(tables, 1)], seed)


def _level(tables: Sequence[Table], seed: int) -> list[Station]:
    stations: list[Station] = []
    for table in tables:
        station = _station(table, seed)
        if station.address in (other.address for other in stations):
            raise ValueError(f"{table.where}: address = {station.address} is taken: use another")
        stations.append(station)
    return stations


def _station(table: Table, seed: int) -> Station:
    address = table.need("address", STATION)
    kind = table.take("kind", choice(_KINDS), _KINDS["drive"])
    edition = table.take("edition", choice(EDITIONS), EDITIONS[kind.edition])
    rates = table.take("rates", several(_rate), list(RATES))
    initialization = Initialization(rates)
    if kind.model:
        equipment = Equipment.of_drive(table, address, seed, kind.model, lambda: initialization.accepted.tmas)
    else:
        equipment = Equipment.of_control(table, address, seed, kind.synax)
    memory, worn = Memory(f"{seed} memory {address}"), table.take("worn", flag, False)
    flash = Flash(memory, equipment.phases.at, edition, _restarting(equipment, initialization), worn)
    services = {
        **{service: by_layout(service) for service in LAYOUTS},
        0x00: _identification(table, kind, rates),
        0x02: flash.service,
        0x03: initialization.service,
        **_services_of_devices(kind, edition, equipment),
    }
    station = Station(
        address,
        edition,
        services,
        initialization,
        groups=table.take("groups", several(whole(edition.groups[0], edition.groups[-1])), []),
        refuse=table.take("refuse", _refuse, _NOTHING),
        available=lambda service: service in _LOADER_SERVICES or not flash.in_loader,
        error=lambda: flash.error or any(drive.error is not None for drive in equipment.drives),
        terminal=Terminal(address, equipment.by_address[address]) if kind.model else None,
        behind=_level(table.take("behind", tables(f"{table.where}, behind"), []), seed),
    )
    if edition.lists:
        services[LIST] = service_list(station.execute)
    table.end()
    return station


def _restarting(equipment: Equipment, initialization: Initialization) -> Callable[[], None]:
    """Return what happens after the loader: the rate stays, as it was accepted."""

    def restart() -> None:
        equipment.restart()
        initialization.power_on(initialization.accepted.baud)

    return restart


def _identification(table: Table, kind: _Kind, rates: list[int]) -> Service:
    text = ascii_text(LONGEST_TEXT)
    return identification(
        table.take("type_key", text, kind.type_key), table.take("firmware", text, kind.firmware), rates
    )


def _services_of_devices(kind: _Kind, edition: Edition, equipment: Equipment) -> dict[int, Service]:
    """Return the services for parameters, general and of the product group, and for phases. ECODRIVE has no phase
    services of its own.
    """
    parameters, phases = Parameters(equipment.by_address, edition), equipment.phases
    services = {0x01: cancel(parameters)}
    services |= parameters.services(_GENERAL, Segments(length_words=edition.length_words))
    if kind.group != _GENERAL:
        services |= parameters.services(kind.group, OF_DRIVES if kind.group == _DRIVES else Segments())
    for group in (_GENERAL, kind.group) if kind.synax else (_GENERAL,):
        services |= {group | 0x2: phases.read_service, group | 0xD: phases.switch_service}
    return services


def _rate(value: object) -> int:
    if not isinstance(value, int) or value not in BAUD_MASKS:
        raise ValueError(f"use one of {', '.join(map(str, RATES))}")
    return value


def _refuse(value: object) -> Mapping[int, int]:
    """Read services and the status of their refusal; TOML has the services as text."""
    cure = "use a table of services and status bytes, { 0x80 = 0xF0 }"
    if not isinstance(value, Mapping):
        raise ValueError(cure)
    refuse = {}
    for service, status in value.items():
        try:
            refuse[BYTE(int(service, 0))] = whole(1, 0xFF)(status)
        except ValueError:
            raise ValueError(cure) from None
    return refuse
