"""Images: units linked for every system, run here and in an emulator; memory that they run in."""

import ctypes
import math
import struct
import sys
from pathlib import Path

import llvmlite.binding as llvm
import pytest
import unicorn
from unicorn import arm64_const as arm
from unicorn import x86_const as x86

from carom.dsp.native import mapping
from carom.dsp.native.images import Image, image_of, link
from carom.dsp.native.mapping import addresses_of, mapped
from carom.dsp.native.targets import ARM, WHEEL, targets
from carom.dsp.native.units import for_image

TABLE = [float(7 * i % 11) for i in range(40)]
ASSEMBLY = {
    "first": f"""
@table = internal constant [40 x double] [{", ".join(f"double {value}" for value in TABLE)}]
@floats = internal constant [3 x float] [float 0.5, float 1.5, float 2.5]
@bytes = internal constant [5 x i8] c"\\01\\02\\03\\05\\08"
declare double @second(double, i64)
define double @first(double %x, i64 %i) {{
  %at = getelementptr [40 x double], ptr @table, i64 0, i64 %i
  %value = load double, ptr %at
  %j = urem i64 %i, 3
  %float_at = getelementptr [3 x float], ptr @floats, i64 0, i64 %j
  %float = load float, ptr %float_at
  %more = fpext float %float to double
  %k = urem i64 %i, 5
  %byte_at = getelementptr [5 x i8], ptr @bytes, i64 0, i64 %k
  %byte = load i8, ptr %byte_at
  %least = uitofp i8 %byte to double
  %called = call double @second(double %x, i64 %j)
  %a = fadd double %value, %more
  %b = fadd double %a, %least
  %sum = fadd double %b, %called
  ret double %sum
}}
""",
    "second": """
declare double @exp(double)
define double @second(double %x, i64 %j) noinline {
  switch i64 %j, label %other [ i64 0, label %zero i64 1, label %one i64 2, label %two ]
zero:
  %e = call double @exp(double %x)
  ret double %e
one:
  %p = fmul double %x, 0x400921FB54442D18
  ret double %p
two:
  %q = fadd double %x, 0x4005BF0A8B145769
  ret double %q
other:
  ret double 0.0
}
""",
}


def expected(x: float, i: int, exp: float) -> float:
    called = (exp, x * math.pi, x + math.e)[i % 3]
    return TABLE[i] + (0.5, 1.5, 2.5)[i % 3] + (1, 2, 3, 5, 8)[i % 5] + called


def image_for(target) -> Image:
    made = [for_image(llvm.parse_assembly(text), target) for text in ASSEMBLY.values()]
    return image_of(link(made, ["first"]).content())


@pytest.mark.parametrize("way", ["its file", "a copy"])
def test_code_of_two_units_runs_with_what_it_calls_of_the_system(tmp_path, monkeypatch, way):
    image, file = image_for(targets()[0]), tmp_path / "image"
    file.write_bytes(image.content())
    if way == "a copy":
        monkeypatch.setattr(mapping, "_maps_file", lambda *_: False)
    assert image.needs == ["exp"]
    at = mapped(image, file, addresses_of(image.needs))
    first = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.c_int64)(at + image.functions["first"])
    for i in range(40):
        assert first(0.3, i) == expected(0.3, i, math.exp(0.3))
    if sys.platform == "linux":
        lines = [line.split(maxsplit=5) for line in Path("/proc/self/maps").read_text().splitlines()]
        (code,) = (row for row in lines if row[0].startswith(f"{at:x}-"))
        (table,) = (row for row in lines if row[0].startswith(f"{at + len(image.code):x}-"))
        assert (code[1], table[1]) == ("r-xp", "r--p") and (code[-1] == str(file)) == (way == "its file")


def test_a_file_that_cannot_be_mapped_is_copied(tmp_path):
    image = image_for(targets()[0])
    at = mapped(image, tmp_path / "gone", addresses_of(image.needs))
    first = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.c_int64)(at + image.functions["first"])
    assert first(0.3, 4) == expected(0.3, 4, 0.0)


# The emulator has no vectors of 256 bits.
@pytest.mark.parametrize("target", [each for each in WHEEL if each.processor in (ARM, "x86-64-v2")], ids=str)
def test_the_images_of_all_systems_run_in_an_emulator(target):
    """The function that they call there gives 2.5."""
    image, base, stack = image_for(target), 0x5_1234_0000, 0x9_0000_0000
    arms = target.processor == ARM
    kind = (unicorn.UC_ARCH_ARM64, unicorn.UC_MODE_ARM) if arms else (unicorn.UC_ARCH_X86, unicorn.UC_MODE_64)
    machine = unicorn.Uc(*kind)
    size = len(image.code)
    machine.mem_map(base, (size + 8 * len(image.needs) + 0xFFFF) & ~0xFFFF)
    machine.mem_map(stack, 0x1_0000)
    # The function that is called, and the place where all ends, lie on the stack's first page.
    outer, end, middle = stack + 0x100, stack + 0x200, stack + 0x8000
    back = struct.pack("<II", 0x1E60_9000 | 4 << 13, 0xD65F_03C0)  # fmov d0, 2.5; ret
    fetched = b"\xf2\x0f\x10\x05\x01\x00\x00\x00\xc3" + struct.pack("<d", 2.5)  # movsd xmm0, [rip + 1]; ret
    machine.mem_write(base, image.code + struct.pack(f"<{len(image.needs)}Q", *[outer] * len(image.needs)))
    machine.mem_write(outer, back if arms else fetched)
    for i in range(40):
        x = 0.75
        if arms:
            machine.reg_write(arm.UC_ARM64_REG_CPACR_EL1, 0x30_0000)
            machine.reg_write(arm.UC_ARM64_REG_SP, middle)
            machine.reg_write(arm.UC_ARM64_REG_LR, end)
            machine.reg_write(arm.UC_ARM64_REG_X0, i)
            machine.reg_write(arm.UC_ARM64_REG_D0, struct.unpack("<Q", struct.pack("<d", x))[0])
        else:
            machine.mem_write(middle - 8, struct.pack("<Q", end))
            machine.reg_write(x86.UC_X86_REG_RSP, middle - 8)
            machine.reg_write(x86.UC_X86_REG_RDX if target.system == "windows" else x86.UC_X86_REG_RDI, i)
            machine.reg_write(x86.UC_X86_REG_XMM0, struct.unpack("<Q", struct.pack("<d", x))[0])
        machine.emu_start(base + image.functions["first"], end)
        found = machine.reg_read(arm.UC_ARM64_REG_D0 if arms else x86.UC_X86_REG_XMM0) & (1 << 64) - 1
        assert struct.unpack("<d", struct.pack("<Q", found))[0] == expected(x, i, 2.5), i


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("@n = global i64 1\ndefine ptr @first() {\n ret ptr @n\n}", r"data of its own that can change \(\.data\)"),
        (
            "@n = external global i64\ndefine i64 @first() {\n %n = load i64, ptr @n\n ret i64 %n\n}",
            "refers otherwise than by a distance",
        ),
    ],
)
def test_code_that_an_image_cannot_hold_is_refused(text, said):
    with pytest.raises(TypeError, match=said):
        link([for_image(llvm.parse_assembly(text), WHEEL[0])], ["first"])


def test_other_files_are_refused():
    with pytest.raises(ValueError, match="an object file of another format than ELF"):
        link([b"MZ\x90\0\3\0\0\0"], [])


def test_a_function_that_no_library_has_has_no_address():
    assert addresses_of(["exp", "carom_has_no_such_function"]) is None
    assert all(addresses_of(["exp", "clock_gettime"]))
