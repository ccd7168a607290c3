//! Which vector instructions the scans run on, found out when the program runs.

/// A set of vector instructions. All give the same map to the bit: no operation is fused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Instructions {
    /// What the program was compiled for: SSE2 on x86-64, NEON on AArch64.
    Baseline,
    /// AVX2, eight lanes of single precision.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512, sixteen lanes of single precision.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Instructions {
    /// The sets that this machine has, the best last.
    pub fn available() -> Vec<Self> {
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

    /// The best set that this machine has.
    pub fn best() -> Self {
        Self::available().pop().unwrap_or(Self::Baseline)
    }
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
