"""What tests of meshes share."""

import pytest

from carom.dsp.mesh import model


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Solids of a third of the cells, of degree 2: for what does not depend on their number."""
    monkeypatch.setattr(model, "CELLS", (2, 24))
