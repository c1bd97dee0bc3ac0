# SPDX-License-Identifier: GPL-2.0-or-later
"""The devices of a station, made from its table: one drive, or a control and its drives. Gates stand before them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from sisbus.devices import parameter_sets
from sisbus.devices.device import Device, Gate
from sisbus.devices.drive import Drive, IndraDrive
from sisbus.devices.parameter_sets import changed
from sisbus.devices.parameters import AccessError, Element
from sisbus.devices.phases import MASTER_AXIS_TURNS, OPERATING_MODE, Phases
from sisbus.service import ChannelError, Request, ServiceFailed
from sisbus.table import Misread, Table, flag, whole

_CHANNEL_NOT_OPEN = 0x0001
_CHANNEL_BUSY = 0x8001
_NOT_ALLOWED = 0x00A0
_ELEMENT_NOT_ALLOWED = 0x00B0
_FIRST_WITH_CHANNEL = 2  # the phase from which on drives have a service channel


def to_drive(device: Device) -> Gate:
    """Guard a drive that is a station itself: its service channel is busy while its phase is switched."""

    def gate(request: Request) -> None:
        if device.phases.busy(request.now_ns):
            raise AccessError(_CHANNEL_BUSY)

    return gate


def to_control(*, refuses_elements: bool) -> Gate:
    """Guard a control. SYNAX refuses writes to elements other than data and ident number itself."""

    def gate(request: Request) -> None:
        writes, element = request.service & 0x0F >= 0xE, request.body[0] >> 3 & 7
        if refuses_elements and writes and element not in (Element.DATA, Element.IDENT_NUMBER):
            raise AccessError(_ELEMENT_NOT_ALLOWED)

    return gate


def through_control(device: Device, off: bool, *, initialization_mode: bool) -> Gate:
    """Guard a drive behind a control.

    It may be switched off. While phases are switched the way to it is busy. Before phase 2 there is none: SYNAX calls
    that the initialization mode and does not allow the request.
    """

    def gate(request: Request) -> None:
        if request.body[2] != 0:
            return  # parameters of the axis are in the control
        if off:
            raise ServiceFailed.in_channel(ChannelError.FAULT)
        if device.phases.switching(request.now_ns):
            raise ServiceFailed.in_channel(ChannelError.BUSY)
        if device.phases.at(request.now_ns) < _FIRST_WITH_CHANNEL:
            raise AccessError(_NOT_ALLOWED if initialization_mode else _CHANNEL_NOT_OPEN)

    return gate


# -- The devices -----------------------------------------------------------------------------------------------------

_OWN = 0  # device address of a control, and the second one of a drive (fig. 8-2)
_DEVICE = whole(1, 254)
_SWITCHING_MS = 400


class DriveModel(NamedTuple):
    """Which drive a station is."""

    made: type[Drive]
    sets: tuple[str, ...]  # sets of parameters; a later one overrides an earlier one


ECODRIVE = DriveModel(Drive, ("drive",))
INDRADRIVE = DriveModel(IndraDrive, ("drive", "indradrive"))


class Equipment:
    """Devices by their addresses, and their common phase."""

    def __init__(self, table: Table) -> None:
        """Take the phase from the table. May raise ValueError."""
        self.drives: list[Drive] = []
        self.by_address: dict[int, Device] = {}
        self._turning = False
        self.phases = Phases(
            table.take("phase", whole(0, OPERATING_MODE), OPERATING_MODE), _SWITCHING_MS, self._against
        )

    @classmethod
    def of_drive(
        cls, table: Table, address: int, seed: int, model: DriveModel, tmas_ms: Callable[[], int | None]
    ) -> Equipment:
        """Return the equipment of a drive that is a station itself; it has its own address and 0."""
        equipment = cls(table)
        made = _made(table, *model.sets)
        drive = model.made(made.parameters, f"{seed} drive {address}", made.modulo, tmas_ms)
        drive.gate = to_drive(drive)
        equipment.by_address |= {address: drive, _OWN: drive}
        drive.join(equipment.phases)
        equipment.drives.append(drive)
        return equipment

    @classmethod
    def of_control(cls, table: Table, address: int, seed: int, synax: bool) -> Equipment:
        """Return the equipment of a control; its drives are in the key `devices`."""
        equipment = cls(table)
        equipment._turning = table.take("turning", flag, False)
        own = Device(_made(table, "control").parameters)
        own.join(equipment.phases)
        own.gate = to_control(refuses_elements=synax)
        equipment.by_address[_OWN] = own
        add = partial(equipment._add, seed=f"{seed} drive {address}", synax=synax)
        table.each("devices", f"{table.where}, device", add)
        return equipment

    def restart(self) -> None:
        """Switch all of them off and on."""
        self.phases.restart()
        for device in self.by_address.values():
            device.restart()

    def _add(self, table: Table, seed: str, synax: bool) -> None:
        address = table.need("address", _DEVICE)
        if address in self.by_address:
            raise Misread(f"{table.where}: address = {address} is taken: use another")
        made = _made(table, "drive", "axis")
        drive = Drive(made.parameters, f"{seed}.{address}", made.modulo)
        drive.gate = through_control(drive, table.take("off", flag, False), initialization_mode=synax)
        self.by_address[address] = drive
        drive.join(self.phases)
        self.drives.append(drive)

    def _against(self, target: int, now_ns: int) -> int | None:
        """Return the code of fig. 8-49 that prevents a phase."""
        if self._turning:
            return MASTER_AXIS_TURNS
        codes = (drive.hindrance(target, now_ns) for drive in self.drives)
        return next((code for code in codes if code is not None), None)


def _made(table: Table, *sets: str) -> parameter_sets.Made:
    """Make the parameters of built-in sets, with the changes in a table."""
    rows = {name: row for each in sets for name, row in parameter_sets.built_in(each).items()}
    return parameter_sets.make(table.take("parameters", lambda changes: changed(rows, changes), rows), table.where)
