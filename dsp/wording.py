"""Suggestions in errors for a word that is not known: the nearest of the known words, else all of them."""

from collections.abc import Iterable, Sequence
from itertools import islice

_LONGEST = 64  # characters of a word that is compared: a longer one is no misspelt name
_MOST_LETTERS = 4_096  # of the known words that are compared: more would hold up a server
_NEAR = 0.7  # of likeness, 0 to 1, for a word of another length
_AS_NEAR = 0.1  # of likeness, 0 to 1, by which others may be less near than the nearest
_MOST_LISTED = 64  # words that an error names
_MOST_SHOWN = 8  # names of things that there are
_SHORTEST_PART = 3  # letters that are looked for inside the known words

MOST_COMPARED = 128
"""Names of things that there are among which a near one is looked for."""


def there_are(names: Iterable[str]) -> str:
    """Say which things there are, the first of them, for an error."""
    shown = list(islice(names, _MOST_SHOWN))
    return f"there {'are' if len(shown) > 1 else 'is'} {', '.join(shown) or 'none'}"


def near(word: str, known: Iterable[str]) -> list[str]:
    """Return up to three known words that a misspelt or cut one may stand for, the nearest first."""
    if len(word) > _LONGEST or not any(letter.isalpha() for letter in word):  # a number is not misspelt, but wrong
        return []
    import difflib  # for an error alone

    folded: dict[str, str] = {}
    letters = 0
    for each in known:
        letters += len(each)
        if letters > _MOST_LETTERS:
            break
        folded.setdefault(each.casefold(), each)
    wanted = word.casefold()
    found = difflib.get_close_matches(wanted, folded)
    likeness = [difflib.SequenceMatcher(None, each, wanted).ratio() for each in found]
    found = [
        each
        for each, like in zip(found, likeness, strict=True)
        if like > likeness[0] - _AS_NEAR and (like > _NEAR or len(each) == len(wanted))
    ]
    if not found and len(wanted) >= _SHORTEST_PART:
        found = [each for each in folded if wanted in each][:3]
    return [folded[each] for each in found]


def suggestion(word: object, known: Iterable[str]) -> str:
    """Ask whether a near word is meant; "" where there is none, or where `word` is no text."""
    found = near(word, known) if isinstance(word, str) else []
    return f"did you mean {' or '.join(found)}?" if found else ""


def expected(word: object, known: Iterable[str]) -> str:
    """Ask whether a near word is meant, or else list all the words that are expected."""
    words = list(known)
    return suggestion(word, words) or (f"expected one of {listed(words)}" if words else "there is none")


def listed(words: Sequence[str]) -> str:
    """List the words, or the first of them and the number of the others."""
    more = len(words) - _MOST_LISTED
    return ", ".join(words[:_MOST_LISTED]) + (f" and {more:,} more" if more > 0 else "")
