"""Results of a run apart from the spectra it was made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native

Image = npt.NDArray[np.complex64]
PICTURES = ("image", "radargram_raw", "radargram_clean")


@dataclass(frozen=True)
class Results:
    """What `_native.Run` gives, as arrays and texts; this much of a run is pickled."""

    name: str
    image: Image
    volume: Image | None
    grid: _native.Plane | _native.Surface | _native.Volume
    origin_deg_m: list[float] | None
    findings: str
    warnings: list[str]
    texts: dict[str, str]
    pictures: dict[str, bytes | None]

    @classmethod
    def of(cls, run: _native.Run | Results) -> Results:
        """The results of a run."""
        if isinstance(run, Results):
            return run
        return cls(
            name=run.name,
            image=run.image,
            volume=run.volume,
            grid=run.grid,
            origin_deg_m=run.origin_deg_m,
            findings=run.findings,
            warnings=run.warnings,
            texts={"record": run.record(), "targets": run.targets()},
            pictures={kind: run.picture(kind) for kind in PICTURES},
        )

    def record(self) -> str:
        """``run.json``."""
        return self.texts["record"]

    def targets(self) -> str:
        """``targets.json``."""
        return self.texts["targets"]

    def picture(self, kind: str) -> bytes | None:
        """A picture as PNG."""
        if kind not in self.pictures:
            raise ValueError(f'kind: expected one of {", ".join(PICTURES)}, found "{kind}"')
        return self.pictures[kind]

    def prepared(self) -> Any:
        """No spectra."""
        raise _native.AcerraError(
            "prepared: expected the run of this process, found one out of a pickle, which holds "
            "results alone; prepare the campaign again, or pickle run.prepared.spectrum"
        )
