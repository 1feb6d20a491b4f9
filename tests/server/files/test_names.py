"""Names of files: such as every system takes, in no other folder, no two the same."""

import unicodedata
from pathlib import PurePosixPath, PureWindowsPath

import pytest
from hypothesis import given
from hypothesis import strategies as st

from carom.server.files.names import file_names

RESERVED = ["con", "NUL", "aux.x", "Com1", "lpt³.a", "CONIN$"]


@pytest.mark.parametrize(
    ("name", "made"),
    [
        ("bell", "bell"),
        ("Glocke-2~3.a", "Glocke-2~3.a"),
        ("\\..\\y", "%5C..%5Cy"),
        ("../../etc", "%2E.%2F..%2Fetc"),
        ("c:x", "c%3Ax"),
        (".hidden", "%2Ehidden"),
        ("-rf", "%2Drf"),
        ("end.", "end%2E"),
        ("50%", "50%25"),
        ("nul.a", "%6Eul.a"),
        ("é" * 64, "é" * 64),
    ],
)
def test_a_name_is_made_safe(name, made):
    assert file_names([name]) == {name: made}


signs = st.sampled_from('aA.\\/:*?"<>|%-é\u0301e \0\x1b😀')
names = st.text(signs | st.characters(exclude_categories=["Cs"]), max_size=64)


@pytest.mark.slow
@given(st.lists(names | st.sampled_from(RESERVED), unique=True, max_size=8))
def test_all_names_are_safe_and_differ_on_every_system(asked):
    made = list(file_names(asked).values())
    assert len({unicodedata.normalize("NFC", each).casefold() for each in made}) == len(asked)
    for each in made:
        file = f"{each}.wav"
        assert PurePosixPath(file).parts == PureWindowsPath(file).parts == (file,)
        assert len(file.encode()) <= 200 and not file.startswith(".") and each[-1] not in ". "
        assert not set(each) & set('\\/:*?"<>|\0') and each.split(".")[0].lower() not in ("con", "nul", "aux", "com1")
