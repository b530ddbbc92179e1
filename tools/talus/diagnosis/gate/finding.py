"""A finding: what makes a recording doubtful, with what was seen and what to do."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """`id` is the contract's (GAP.json, `findings`); while a grave one stands no cause is named."""

    id: str
    grave: bool
    column: str
    evidence: str
    remedy: str

    def entry(self):
        """As GAP.json has it."""
        return {"id": self.id, "grave": self.grave, "column": self.column, "evidence": self.evidence, "remedy": self.remedy}


def worst_first(findings):
    """Grave ones first, each thing once."""
    seen = {}
    for finding in findings:
        seen.setdefault((finding.id, finding.column), finding)
    return sorted(seen.values(), key=lambda f: not f.grave)
