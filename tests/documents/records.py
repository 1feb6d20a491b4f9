"""The records that follow from the schema, as editors and mypy read them: `dsp/schema_records.pyi`."""

from pathlib import Path
from typing import Any

from carom.dsp import schema_records
from carom.dsp.counters import Stats
from carom.dsp.native.typed import Record
from carom.dsp.schema import GESTURES, SETTINGS
from carom.dsp.schema_values import OF_RAMPS, OWN, SHARED

STUB = Path(__file__).parents[2] / "dsp" / "schema_records.pyi"

_ARGUMENTS = {each.argument.name: each.argument for each in GESTURES.values()}
_VALUES = [*OWN.values(), SHARED, SETTINGS, OF_RAMPS, _ARGUMENTS]
_UNITS = {each.name: each.unit for values in _VALUES for each in values.values()}
_UNITS |= {name: str(each.metadata["unit"]) for name, each in Stats.__dataclass_fields__.items()}
_IN_ENGINE = {"dB": "as amplitude", "semitones": "as ratio"}

_HEAD = '''\
"""Records of the numbers that the schema declares, as the engine holds them; `make documents` writes this."""

import numpy as np

from .native.typed import Record

'''


def stub() -> str:
    """Return the text of the stub."""
    records = schema_records.RECORDS
    dtypes = [name for name, value in vars(schema_records).items() if name.isupper() and hasattr(value, "fields")]
    text = _HEAD + "\n".join(map(_declared, records))
    return text + "\n" + "".join(f"{name}: np.dtype[np.void]\n" for name in sorted(dtypes))


def _declared(record: type[Record]) -> str:
    """Return the declaration of a record."""
    fields = [_field(name, kind) for name, kind in record.__annotations__.items()]
    return f'class {record.__name__}(Record):\n    """{record.__doc__}"""\n\n' + "".join(fields)


def _field(name: str, kind: Any) -> str:
    unit = _UNITS.get(name, "")
    unit = _IN_ENGINE.get(unit, unit)
    return f"    {name}: {kind.__name__}{f'  # {unit}' if unit else ''}\n"
