"""Object files for WebAssembly, linked: what is left out, and what stays as LLVM made it."""

import subprocess

import llvmlite.binding as llvm
import pytest

from carom.dsp.native import wasm_object
from carom.dsp.native.wasm import TARGET, data_end, linked
from tests import needs

pytestmark = needs.without("node")

ASSEMBLY = """
@near = internal constant [3 x i8] c"abc", align 1
@far = internal constant [300 x double] [{values}], align 16
@unused = internal constant [5 x double] zeroinitializer, align 8

define internal i32 @_ZN4room3oneE(ptr %0, i32 %1) noinline {{
  %at = getelementptr [300 x double], ptr @far, i32 0, i32 %1
  %before = getelementptr double, ptr %at, i32 -2
  %value = load double, ptr %before
  store double %value, ptr %0
  ret i32 0
}}

define internal i32 @_ZN5other3oneE(ptr %0, i32 %1) noinline {{
  %at = getelementptr [3 x i8], ptr @near, i32 0, i32 %1
  %byte = load i8, ptr %at
  %value = uitofp i8 %byte to double
  store double %value, ptr %0
  ret i32 0
}}

define double @ask(i32 %0) {{
  %place = alloca double
  store double 7.0, ptr %place
  %told = call i32 @_ZN4room3oneE(ptr %place, i32 %0)
  %one = load double, ptr %place
  %failed = call i32 @_ZN5other3oneE(ptr %place, i32 1)
  %two = load double, ptr %place
  %sum = fadd double %one, %two
  ret double %sum
}}

define double @other(i32 %0) {{
  ret double 3.0
}}
"""

RUN = """
const module = new WebAssembly.Module(Buffer.from(process.argv[1], "hex"));
const memory = new WebAssembly.Memory({ initial: 2 });
const stack = new WebAssembly.Global({ value: "i32", mutable: true }, 65536);
const made = new WebAssembly.Instance(module, { env: { __linear_memory: memory, __stack_pointer: stack } });
console.log(Object.keys(made.exports).join(), made.exports.ask(202));
"""


@pytest.fixture(scope="module")
def made() -> bytes:
    text = ASSEMBLY.format(values=", ".join(f"double {n}.5" for n in range(300)))
    machine = TARGET.machine()
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = TARGET.triple, str(machine.target_data)
    content: bytes = machine.emit_object(module)
    return content


def run(content: bytes) -> str:
    return subprocess.run(["node", "-e", RUN, content.hex()], capture_output=True, text=True, check=True).stdout.strip()


@pytest.mark.slow
def test_a_linked_module_runs_with_what_it_needs_alone(made: bytes) -> None:
    """A function and data that no export needs are left out; calls and addresses are those of what stays."""
    read = wasm_object.read(made)
    assert (len(read.functions), len(read.segments)) == (4, 3)
    whole = linked(made, ["ask", "other"])
    assert run(whole) == f"ask,other {200.5 + ord('b')}"
    assert data_end(whole) == 16 + 2400
    assert run(linked(made, ["ask"])) == f"ask {200.5 + ord('b')}" and len(linked(made, ["ask"])) < len(whole)


def test_a_kernel_that_is_left_out_does_nothing(made: bytes) -> None:
    """A kernel by the beginning of its name returns that nothing failed, and its data go."""
    without = linked(made, ["ask"], ("room",))
    assert run(without) == f"ask {7 + ord('b')}"
    assert data_end(without) == 3
    assert run(linked(made, ["ask"], ("other", "room"))) == "ask 14"
