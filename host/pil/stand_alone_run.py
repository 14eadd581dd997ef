"""The image navigates by itself: fed with the raw frames of a twin's run, its solutions are compared."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from hal.live.port import PortError
from host.attach.board_session import BoardSession
from host.attach.board_setup import board_setup
from host.attach.fed_board import FedBoard, inputs_of
from host.attach.feeding import Input
from host.attach.shadow import Shadow
from host.pil.image import BAUD, Image
from host.pil.qemu import emulated_board
from host.pil.session import image_of
from host.pil.stand_alone import stand_alone_of
from host.pil.toolchain import COMPILER, EMULATOR, check_tools
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.readiness import prepared
from host.run.runner import run
from host.run.setup import BOARD_PREFIX, PROFILE_PREFIX, Setup

FORMAT = "navtwin-pil-stand-alone-1"
TELL_ALL = ("profile.raw_output=true", "expect={}")


@dataclass(frozen=True, slots=True)
class StandAloneResult:
    """What was compared; `to_dict` is what --json writes."""

    board: str
    profile: str
    scenario: str
    seed: int
    target: str
    identity: str
    image_bytes: int
    inputs: int
    inputs_taken: int
    inputs_repeated: int
    """Lost on the line and sent again."""
    solutions_equal: int
    solutions_different: int
    solutions_unchecked: int
    copies_equal: int
    copies_different: int
    differences: list[str]
    wall_s: float

    @property
    def is_equal(self) -> bool:
        """Whether all was taken and nothing differs."""
        return bool(not self.differences and self.solutions_equal and self.inputs_taken == self.inputs)

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {"format": FORMAT, **asdict(self), "equal": self.is_equal}


def run_stand_alone(request: RunRequest, port: str | None, notice: Callable[[str], None]) -> StandAloneResult:
    """Run the twin, then the image on what the twin's navigation took in. Raises UserError."""
    setup, _ = prepared(request)
    if stand_alone_of(setup.board, setup.profile) is None:
        raise UserError(
            f"board {setup.board.name}: its program has no module stand_alone that an image could navigate"
            " with by itself; for example navtwin pil car_mems --stand-alone"
        )
    check_tools(COMPILER, *([EMULATOR] if port is None else []))
    notice("building the image (a minute when the kernels are new) …")
    image = image_of(request, as_asked=True)
    inputs = _inputs_of_run(request)
    begin = time.perf_counter()
    with emulated_board(image.file("elf")) if port is None else nullcontext(port) as name:
        source = _fed_board(name, inputs)
        try:
            shadow = Shadow(_shadow_setup(request, setup).loop())
            session = BoardSession(source, shadow, None, lambda *_: None, notice)
            session.run(None)
            figures = session.result().line
        finally:
            source.close()
    return _result(request, setup, image, port, shadow, figures, time.perf_counter() - begin)


def _inputs_of_run(request: RunRequest) -> list[Input]:
    with tempfile.TemporaryDirectory(prefix="navtwin-pil-") as place:
        run(replace(request, overrides=(*request.overrides, *TELL_ALL), out_dir=Path(place), capture=True))
        return inputs_of(Path(place, "run.mcap"), "the twin's run")


def _fed_board(name: str, inputs: list[Input]) -> FedBoard:
    try:
        return FedBoard(name, BAUD, inputs)
    except PortError as error:
        raise UserError(f"--port {error}") from None


def _shadow_setup(request: RunRequest, setup: Setup) -> Any:
    own = tuple(one for one in request.overrides if one.startswith((BOARD_PREFIX, PROFILE_PREFIX)))
    return board_setup(request.board, setup.profile_name, own)


def _result(
    request: RunRequest,
    setup: Setup,
    image: Image,
    port: str | None,
    shadow: Shadow,
    figures: dict[str, Any],
    wall_s: float,
) -> StandAloneResult:
    counts = shadow.counts
    return StandAloneResult(
        board=setup.board.name,
        profile=setup.profile_name,
        scenario=setup.scenario.name,
        seed=request.seed,
        target="QEMU netduinoplus2" if port is None else port,
        identity=image.identity,
        image_bytes=image.size,
        inputs=figures["inputs"],
        inputs_taken=figures["inputs_taken"],
        inputs_repeated=figures["inputs_repeated"],
        solutions_equal=counts.solutions_equal,
        solutions_different=counts.solutions_different,
        solutions_unchecked=counts.solutions_unchecked,
        copies_equal=counts.copies_equal,
        copies_different=counts.copies_different,
        differences=[one.text() for one in shadow.differences],
        wall_s=wall_s,
    )
