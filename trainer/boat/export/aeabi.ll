; What the code generator asks of a library on an ARM processor of 32 bits, by the names of its ABI.
;
; Their calls appear only in machine code. They hand numbers over in integer registers. A conversion
; rounds once at most, so that the bits are those of any correct library.

; Return the whole part of x, where an integer of 64 bits holds it.
define arm_aapcscc i64 @__aeabi_d2lz(double %x) noinline {
  %bits = bitcast double %x to i64
  %field = lshr i64 %bits, 52
  %biased = and i64 %field, 2047
  %fraction = and i64 %bits, 4503599627370495
  %mantissa = or i64 %fraction, 4503599627370496
  %up = sub i64 %biased, 1075
  %down = sub i64 1075, %biased
  %large = icmp sgt i64 %up, 0
  %raised = shl i64 %mantissa, %up
  %lowered = lshr i64 %mantissa, %down
  %tiny = icmp sgt i64 %down, 52
  %whole = select i1 %tiny, i64 0, i64 %lowered
  %size = select i1 %large, i64 %raised, i64 %whole
  %minus = icmp slt i64 %bits, 0
  %opposite = sub i64 0, %size
  %n = select i1 %minus, i64 %opposite, i64 %size
  ret i64 %n
}

; Return n, or n without a sign, as a double: the product is exact, and the sum rounds.
define arm_aapcscc double @__aeabi_l2d(i64 %n) noinline {
  %shifted = ashr i64 %n, 32
  %high = trunc i64 %shifted to i32
  %above = sitofp i32 %high to double
  %x = call double @trainer_joined(double %above, i64 %n)
  ret double %x
}

define arm_aapcscc double @__aeabi_ul2d(i64 %n) noinline {
  %shifted = lshr i64 %n, 32
  %high = trunc i64 %shifted to i32
  %above = uitofp i32 %high to double
  %x = call double @trainer_joined(double %above, i64 %n)
  ret double %x
}

define double @trainer_joined(double %above, i64 %n) alwaysinline {
  %low = trunc i64 %n to i32
  %below = uitofp i32 %low to double
  %scaled = fmul double %above, 4294967296.0
  %x = fadd double %scaled, %below
  ret double %x
}

declare ptr @memset(ptr, i32, i32)
declare ptr @memcpy(ptr, ptr, i32)

; Blocks at addresses that eight divides.
define arm_aapcscc void @__aeabi_memclr8(ptr %first, i32 %count) "no-builtins" noinline {
  %end = call ptr @memset(ptr %first, i32 0, i32 %count)
  ret void
}

define arm_aapcscc void @__aeabi_memcpy8(ptr %first, ptr %source, i32 %count) "no-builtins" noinline {
  %end = call ptr @memcpy(ptr %first, ptr %source, i32 %count)
  ret void
}

@llvm.compiler.used = appending global [5 x ptr] [
  ptr @__aeabi_d2lz, ptr @__aeabi_l2d, ptr @__aeabi_ul2d, ptr @__aeabi_memclr8, ptr @__aeabi_memcpy8
], section "llvm.metadata"
