; What the tick asks of the libraries around it, so that it needs none of them.
;
; The names are those that numba and the code generator call. What rounds does so once, so that the
; bits are those of any correct C library. %size is an integer as wide as a pointer, defined before
; this text.

declare double @llvm.sqrt.f64(double)

; Records are lent, not owned: there is nothing to count.
define void @NRT_incref(ptr %owner) alwaysinline {
  ret void
}

define void @NRT_decref(ptr %owner) alwaysinline {
  ret void
}

define double @sqrt(double %x) alwaysinline {
  %root = call double @llvm.sqrt.f64(double %x)
  ret double %root
}

; Return x, and n less the powers of two that it was multiplied by: 2^1023 or 2^-969 if n is beyond
; what one factor can hold. 2^-969 leaves 53 bits to spare, so that only the last product rounds.
define { double, i32 } @trainer_approach(double %x, i32 %n) alwaysinline {
  %above = icmp sgt i32 %n, 1023
  %below = icmp slt i32 %n, -1022
  %shrunk = select i1 %below, double 0x0360000000000000, double 1.0
  %factor = select i1 %above, double 0x7FE0000000000000, double %shrunk
  %raised = select i1 %below, i32 969, i32 0
  %change = select i1 %above, i32 -1023, i32 %raised
  %y = fmul double %x, %factor
  %m = add i32 %n, %change
  %part = insertvalue { double, i32 } poison, double %y, 0
  %both = insertvalue { double, i32 } %part, i32 %m, 1
  ret { double, i32 } %both
}

; Return x 2^n.
define double @numba_ldexp(double %x, i32 signext %n) alwaysinline {
  %once = call { double, i32 } @trainer_approach(double %x, i32 %n)
  %x1 = extractvalue { double, i32 } %once, 0
  %n1 = extractvalue { double, i32 } %once, 1
  %twice = call { double, i32 } @trainer_approach(double %x1, i32 %n1)
  %x2 = extractvalue { double, i32 } %twice, 0
  %n2 = extractvalue { double, i32 } %twice, 1
  %above = icmp sgt i32 %n2, 1023
  %most = select i1 %above, i32 1023, i32 %n2
  %below = icmp slt i32 %most, -1022
  %least = select i1 %below, i32 -1022, i32 %most
  %biased = add i32 %least, 1023
  %wide = zext i32 %biased to i64
  %bits = shl i64 %wide, 52
  %power = bitcast i64 %bits to double
  %y = fmul double %x2, %power
  ret double %y
}

; Return m in [0.5, 1) and write e, x = m 2^e; zero and what is not finite come back with e = 0.
define double @numba_frexp(double %x, ptr %e) alwaysinline {
  %xbits = bitcast double %x to i64
  %xfield = lshr i64 %xbits, 52
  %xexponent = and i64 %xfield, 2047
  %tiny = icmp eq i64 %xexponent, 0
  %scaled = fmul double %x, 0x43F0000000000000
  %y = select i1 %tiny, double %scaled, double %x
  %offset = select i1 %tiny, i64 1086, i64 1022
  %bits = bitcast double %y to i64
  %field = lshr i64 %bits, 52
  %exponent = and i64 %field, 2047
  %unchanged = icmp eq i64 %xexponent, 2047
  %zero = fcmp oeq double %x, 0.0
  %plain = or i1 %unchanged, %zero
  %kept = and i64 %bits, -9218868437227405313
  %half = or i64 %kept, 4602678819172646912
  %mantissa = bitcast i64 %half to double
  %m = select i1 %plain, double %x, double %mantissa
  %power = sub i64 %exponent, %offset
  %chosen = select i1 %plain, i64 0, i64 %power
  %narrow = trunc i64 %chosen to i32
  store i32 %narrow, ptr %e
  ret double %m
}

; Fill count bytes at first; the code generator calls it for blocks that it does not fill in place.
define ptr @memset(ptr %first, i32 %byte, %size %count) "no-builtins" noinline {
entry:
  %value = trunc i32 %byte to i8
  br label %more
more:
  %i = phi %size [ 0, %entry ], [ %next, %fill ]
  %left = icmp ult %size %i, %count
  br i1 %left, label %fill, label %done
fill:
  %at = getelementptr i8, ptr %first, %size %i
  store i8 %value, ptr %at
  %next = add %size %i, 1
  br label %more
done:
  ret ptr %first
}

; Copy count bytes from source to first, which do not overlap.
define ptr @memcpy(ptr %first, ptr %source, %size %count) "no-builtins" noinline {
entry:
  br label %more
more:
  %i = phi %size [ 0, %entry ], [ %next, %copy ]
  %left = icmp ult %size %i, %count
  br i1 %left, label %copy, label %done
copy:
  %from = getelementptr i8, ptr %source, %size %i
  %to = getelementptr i8, ptr %first, %size %i
  %value = load i8, ptr %from
  store i8 %value, ptr %to
  %next = add %size %i, 1
  br label %more
done:
  ret ptr %first
}

; Their calls appear only in machine code: until then nothing seems to need them.
@llvm.compiler.used = appending global [2 x ptr] [ptr @memset, ptr @memcpy], section "llvm.metadata"
