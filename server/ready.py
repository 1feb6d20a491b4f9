"""The part of a live server's start that needs no engine, which may take minutes to compile: what can be refused is
refused before."""

from .audio.outputs import require_device
from .files.outfile import OutFile
from .files.recorder import require_wav
from .files.takes import made_folder
from .options import Options, ServeError


def require_ready(options: Options) -> None:
    """Raise AudioError, ServeError, RecordError or OSError for what a server could not start with."""
    require_device(options.device)
    if options.record:
        require_wav(options.record)
    for path in filter(None, (options.record, options.log)):
        OutFile(path).close()
    if options.recordings is not None:
        made_folder(options.recordings)
    if options.web is not None:
        _require_web(options)
    if options.midi:
        _require_midi(options)


def _require_web(options: Options) -> None:
    try:
        from .web import server, start  # noqa: F401
        from .web.tls import context
    except ModuleNotFoundError as error:
        option = "oscquery" if options.page is None else "page"
        raise ServeError(f"{option}: {error.name} is missing: pip install 'carom[page]'") from None
    if options.certificate:
        context(options.certificate, options.bind)


def _require_midi(options: Options) -> None:
    try:
        from .midi.ports import found_inputs
    except ModuleNotFoundError as error:
        raise ServeError(f"midi: {error.name} is missing: pip install 'carom[midi]'") from None
    found_inputs(options.midi)
