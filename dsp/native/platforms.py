"""The operations that kernels need of the machine and its system, in LLVM's assembly.

Kernels are translated once, for all systems. They reach all that differs between these by the functions below, which
are linked into their code, and inlined, before it is optimised for a system and a processor.

    i64 carom_monotonic_ns()          the clock, ns
    void carom_pause_ns(i64)          let this thread sleep for some ns
    i64 carom_thread_id()             the system's number of this thread, by which Linux schedules it; 0 elsewhere
    i64 carom_flush_denormals()       set flush-to-zero on this thread; the mode that it had
    void carom_restore_denormals(i64) give it back that mode
    i64 carom_receive(i64 socket, i64 data, i64 size, i64 address, i64 length)   recvfrom, without flags
    void carom_send(i64 socket, i64 data, i64 size)                              send, without flags
"""

_CLOCK_MONOTONIC = {"darwin": 6}
_ELSEWHERE = 1  # the number of that clock

_POSIX = """
declare i32 @clock_gettime(i32, ptr)
declare i32 @nanosleep(ptr, ptr)
declare i64 @recvfrom(i32, ptr, i64, i32, ptr, ptr)
declare i64 @send(i32, ptr, i64, i32)

define i64 @carom_monotonic_ns() {
  %time = alloca [2 x i64]
  %failed = call i32 @clock_gettime(i32 CLOCK_MONOTONIC, ptr %time)
  %seconds = load i64, ptr %time
  %rest = getelementptr i64, ptr %time, i64 1
  %ns = load i64, ptr %rest
  %whole = mul i64 %seconds, 1000000000
  %sum = add i64 %whole, %ns
  ret i64 %sum
}

define void @carom_pause_ns(i64 %duration) {
  %time = alloca [2 x i64]
  %seconds = udiv i64 %duration, 1000000000
  %ns = urem i64 %duration, 1000000000
  %rest = getelementptr i64, ptr %time, i64 1
  store i64 %seconds, ptr %time
  store i64 %ns, ptr %rest
  %failed = call i32 @nanosleep(ptr %time, ptr null)
  ret void
}

define i64 @carom_receive(i64 %socket, i64 %data, i64 %size, i64 %address, i64 %length) {
  %descriptor = trunc i64 %socket to i32
  %to = inttoptr i64 %data to ptr
  %from = inttoptr i64 %address to ptr
  %its_length = inttoptr i64 %length to ptr
  %got = call i64 @recvfrom(i32 %descriptor, ptr %to, i64 %size, i32 0, ptr %from, ptr %its_length)
  ret i64 %got
}

define void @carom_send(i64 %socket, i64 %data, i64 %size) {
  %descriptor = trunc i64 %socket to i32
  %from = inttoptr i64 %data to ptr
  %sent = call i64 @send(i32 %descriptor, ptr %from, i64 %size, i32 0)
  ret void
}
"""

_WINDOWS = """
declare i32 @QueryPerformanceCounter(ptr)
declare void @Sleep(i32)
declare i32 @recvfrom(i64, ptr, i32, i32, ptr, ptr)
declare i32 @send(i64, ptr, i32, i32)

; The performance counter counts 100 ns.
define i64 @carom_monotonic_ns() {
  %count = alloca i64
  %done = call i32 @QueryPerformanceCounter(ptr %count)
  %counted = load i64, ptr %count
  %ns = mul i64 %counted, 100
  ret i64 %ns
}

define void @carom_pause_ns(i64 %duration) {
  %ms = udiv i64 %duration, 1000000
  %short = trunc i64 %ms to i32
  call void @Sleep(i32 %short)
  ret void
}

define i64 @carom_receive(i64 %socket, i64 %data, i64 %size, i64 %address, i64 %length) {
  %to = inttoptr i64 %data to ptr
  %from = inttoptr i64 %address to ptr
  %its_length = inttoptr i64 %length to ptr
  %most = trunc i64 %size to i32
  %short = call i32 @recvfrom(i64 %socket, ptr %to, i32 %most, i32 0, ptr %from, ptr %its_length)
  %got = sext i32 %short to i64
  ret i64 %got
}

define void @carom_send(i64 %socket, i64 %data, i64 %size) {
  %from = inttoptr i64 %data to ptr
  %most = trunc i64 %size to i32
  %sent = call i32 @send(i64 %socket, ptr %from, i32 %most, i32 0)
  ret void
}
"""

_THREAD = """
declare i32 @gettid()

define i64 @carom_thread_id() {
  %number = call i32 @gettid()
  %long = sext i32 %number to i64
  ret i64 %long
}
"""

_NO_THREAD = """
define i64 @carom_thread_id() {
  ret i64 0
}
"""

# MXCSR: bit 15 makes results that are denormal 0, bit 6 takes arguments that are as 0.
_X86 = """
declare void @llvm.x86.sse.stmxcsr(ptr)
declare void @llvm.x86.sse.ldmxcsr(ptr)

define i64 @carom_flush_denormals() {
  %register = alloca i32
  call void @llvm.x86.sse.stmxcsr(ptr %register)
  %mode = load i32, ptr %register
  %flushing = or i32 %mode, 32832
  store i32 %flushing, ptr %register
  call void @llvm.x86.sse.ldmxcsr(ptr %register)
  %long = zext i32 %mode to i64
  ret i64 %long
}

define void @carom_restore_denormals(i64 %mode) {
  %register = alloca i32
  %short = trunc i64 %mode to i32
  store i32 %short, ptr %register
  call void @llvm.x86.sse.ldmxcsr(ptr %register)
  ret void
}
"""

# FPCR: bit 24 does both.
_ARM = """
declare i64 @llvm.aarch64.get.fpcr()
declare void @llvm.aarch64.set.fpcr(i64)

define i64 @carom_flush_denormals() {
  %mode = call i64 @llvm.aarch64.get.fpcr()
  %flushing = or i64 %mode, 16777216
  call void @llvm.aarch64.set.fpcr(i64 %flushing)
  ret i64 %mode
}

define void @carom_restore_denormals(i64 %mode) {
  call void @llvm.aarch64.set.fpcr(i64 %mode)
  ret void
}
"""

_OTHER = """
define i64 @carom_flush_denormals() {
  ret i64 0
}

define void @carom_restore_denormals(i64 %mode) {
  ret void
}
"""


_NOTHING = """
define i64 @carom_monotonic_ns() {
  ret i64 0
}

define void @carom_pause_ns(i64 %duration) {
  ret void
}

define i64 @carom_receive(i64 %socket, i64 %data, i64 %size, i64 %address, i64 %length) {
  ret i64 -1
}

define void @carom_send(i64 %socket, i64 %data, i64 %size) {
  ret void
}
"""


def assembly(system: str, triple: str, flushes: bool = True) -> str:
    """Return the functions for an operating system and LLVM's name of a target; flushes: denormals can be 0."""
    if system == "wasm":
        return _NOTHING + _NO_THREAD + _OTHER
    clock = str(_CLOCK_MONOTONIC.get(system, _ELSEWHERE))
    calls = _WINDOWS if system == "windows" else _POSIX.replace("CLOCK_MONOTONIC", clock)
    thread = _THREAD if system == "linux" else _NO_THREAD
    family = triple.partition("-")[0]
    family = family if flushes else ""
    denormals = _X86 if family == "x86_64" else _ARM if family in ("aarch64", "arm64") else _OTHER
    return calls + thread + denormals
