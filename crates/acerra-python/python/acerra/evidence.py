"""What a run found of its own settings."""

from __future__ import annotations

import html
import json
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from ._native import AcerraError  # noqa: F401  (documented beside the warnings)


class AcerraWarning(UserWarning):
    """What Acerra noticed and the image may suffer from."""


@dataclass(frozen=True)
class Finding:
    """A value that a run has found, beside what it should be.

    Attributes
    ----------
    name : str
        Name of the finding, unique within a run.
    value, expected, sigma : float or None
        The value found, the value if the settings are right, and the standard deviation of their
        difference, in `unit`.
    unit : str
        Unit of the three.
    verdict : {"agrees", "doubtful", "contradicts"}
        The judgement.
    explanation : str
        What was compared, and which settings to look at.
    """

    name: str
    value: float | None
    expected: float | None
    sigma: float | None
    unit: str
    verdict: Literal["agrees", "doubtful", "contradicts"]
    explanation: str


class Evidence(Sequence[Finding]):
    """The findings of a run, in the order of its stages."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        self._findings = tuple(findings)

    @classmethod
    def _from_json(cls, text: str) -> Evidence:
        return cls([Finding(**finding) for finding in json.loads(text)])

    def __len__(self) -> int:
        return len(self._findings)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        return self._findings[index]

    def __iter__(self) -> Iterator[Finding]:
        return iter(self._findings)

    @property
    def disagreeing(self) -> tuple[Finding, ...]:
        """Findings that do not agree with the settings, contradictions first."""
        worst_first = ("contradicts", "doubtful")
        return tuple(f for verdict in worst_first for f in self if f.verdict == verdict)

    def named(self, name: str) -> Finding:
        """The finding of this name.

        Raises
        ------
        KeyError
            Where the run has none.
        """
        for finding in self:
            if finding.name == name:
                return finding
        raise KeyError(f"{name}: expected one of {', '.join(f.name for f in self)}")

    def __repr__(self) -> str:
        agreeing = len(self) - len(self.disagreeing)
        others = "".join(f"; {f.verdict}: {f.name}" for f in self.disagreeing)
        return f"<Evidence: {agreeing} of {len(self)} findings agree{others}>"

    def _repr_html_(self) -> str:
        agreeing = tuple(f for f in self if f.verdict == "agrees")
        folded = (
            f"<details><summary>{len(agreeing)} of {len(self)} findings agree</summary>"
            f"{_table(agreeing)}</details>"
        )
        return (_table(self.disagreeing) if self.disagreeing else "") + folded


def _table(findings: Sequence[Finding]) -> str:
    head = "<tr><th>finding</th><th>verdict</th><th>value</th><th>expected</th><th>σ</th><th></th></tr>"
    return f"<table>{head}{''.join(map(_row, findings))}</table>"


def _row(finding: Finding) -> str:
    def number(value: float | None) -> str:
        return "–" if value is None else f"{value:.4g} {html.escape(finding.unit)}"

    weight = "normal" if finding.verdict == "agrees" else "bold"
    return (
        f'<tr><td>{html.escape(finding.name)}</td><td style="font-weight:{weight}">{finding.verdict}</td>'
        f"<td>{number(finding.value)}</td><td>{number(finding.expected)}</td>"
        f'<td>{number(finding.sigma)}</td><td style="text-align:left">{html.escape(finding.explanation)}'
        "</td></tr>"
    )


def warn_of(evidence: Evidence, noticed: Sequence[str], stacklevel: int = 3) -> None:
    """Warns of what the stages noticed and of findings that do not agree."""
    for text in noticed:
        warnings.warn(text, AcerraWarning, stacklevel=stacklevel)
    for finding in evidence.disagreeing:
        text = f"{finding.name} ({finding.verdict}): {finding.explanation}"
        warnings.warn(text, AcerraWarning, stacklevel=stacklevel)
