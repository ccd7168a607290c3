//! Selects the vector instructions of the CPU engine at run time.

/// A set of vector instructions. All sets give bit-identical maps, since no operations are fused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Instructions {
    /// The instructions that the program was compiled for: SSE2 on x86-64, NEON on AArch64.
    Baseline,
    /// AVX2, with eight lanes of single precision.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512, with sixteen lanes of single precision.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Instructions {
    /// Returns the sets that this machine has. The best set is last.
    pub fn available() -> Vec<Self> {
        #[cfg_attr(not(target_arch = "x86_64"), expect(unused_mut, reason = "there is one set"))]
        let mut available = vec![Self::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") {
                available.push(Self::Avx2);
            }
            if has!("avx2") && has!("avx512f") && has!("avx512dq") && has!("avx512vl") {
                available.push(Self::Avx512);
            }
        }
        available
    }

    /// Returns the best set that this machine has.
    pub fn best() -> Self {
        static BEST: std::sync::OnceLock<Instructions> = std::sync::OnceLock::new();
        *BEST.get_or_init(|| Self::available().pop().unwrap_or(Self::Baseline))
    }
}

/// A loop over points without branches, which the compiler vectorizes.
///
/// This is a trait and not a closure: a closure that is not inlined would be compiled for the baseline
/// instructions. For the same reason `run` and the functions that it calls must be `#[inline(always)]`.
pub trait Loop {
    type Output;

    /// Whether the loop is compiled for AVX-512 too. Otherwise it runs with AVX2 on machines that have both.
    const AVX512: bool = true;

    fn run(self) -> Self::Output;
}

/// Prefetches the part of `array` that starts at element `place` into the caches. `place` may lie outside the
/// array: a prefetch is only a hint, and does nothing where there is no memory.
#[inline(always)]
pub fn prefetch<T>(array: &[T], place: isize) {
    if size_of::<T>() == 0 {
        return;
    }
    let at = array.as_ptr().wrapping_offset(place);
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 machine has SSE, and a prefetch reads nothing. Newer compilers know that, so
        // the block may be unnecessary.
        #[allow(unused_unsafe)]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(at.cast());
        }
    }
    let _ = at;
}

impl Instructions {
    /// Runs `work`, which is compiled once for each instruction set.
    #[doc(hidden)]
    pub fn run<L: Loop>(self, work: L) -> L::Output {
        match self {
            Self::Baseline => work.run(),
            // SAFETY: values of this type are made only for sets that this machine has, by
            // `Instructions::available` and `RotatedScan::with_instructions`.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { avx2(work) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 if L::AVX512 => unsafe { avx512(work) },
            // SAFETY: as above; machines that count as having AVX-512 have AVX2.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { avx2(work) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<L: Loop>(work: L) -> L::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2")]
fn avx512<L: Loop>(work: L) -> L::Output {
    work.run()
}

impl std::fmt::Display for Instructions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Baseline if cfg!(target_arch = "x86_64") => "SSE2",
            Self::Baseline if cfg!(target_arch = "aarch64") => "NEON",
            Self::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "AVX-512",
        })
    }
}
