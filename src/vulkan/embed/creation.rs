//! Defines the methods of a solver that create outputs.

/// Defines three methods of [`super::Solver`] for an output: for its size, and for creating it in memory of its own or
/// of the host. `info` returns the parameters of its memory; `make` returns these and its passes.
macro_rules! creation {
    (
        $output:ident($($room:ident: $kind:ty)?), $hosts:ident: $memory:ident($of:ty);
        $bytes_for:ident($($size:ident: $size_kind:ty),*);
        $(#[$doc:meta])* $create:ident;
        $(#[$into_doc:meta])* $create_into:ident;
    ) => {
        impl Solver {
            #[doc = concat!(
                "Returns the number of bytes of [`", stringify!($output), "`] in the allocator's memory blocks on this \
                 device. No memory is allocated.\n\n# Errors\nAs for [`Solver::", stringify!($create), "`].",
            )]
            pub fn $bytes_for(
                &self,
                device: &ash::Device,
                $($size: $size_kind),*
            ) -> Result<u64, VulkanError> {
                info(&self.limits, $($size),*)?.bytes(device)
            }

            $(#[$doc])*
            ///
            #[doc = concat!(
                "This is the only call that allocates for [`", stringify!($output), "`]. The first call on a solver also \
                 creates the pipelines. The host calls [`Output::destroy`] in the end.",
            )]
            ///
            /// # Errors
            /// If the buffer is larger than shaders can access or has no room, or memory runs out. Nothing is left
            /// behind then.
            pub fn $create(
                &self,
                device: &ash::Device,
                allocator: &mut dyn DeviceMemory,
                surface: &FrameSurface,
                $($room: $kind)?
            ) -> Result<$output, VulkanError> {
                let made = make(device, (self, surface), $($room)?)?;
                Output::new(device, allocator, (self, surface), made, None)
            }

            #[doc = concat!(
                "Creates [`", stringify!($output), "`] as [`Solver::", stringify!($create), "`] does, but in memory of \
                 the host.",
            )]
            ///
            $(#[$into_doc])*
            ///
            /// The host keeps that memory alive until the recordings that write it have run, and destroys it. Each
            /// frame may use other memory ([`Output::set_buffer`], [`Output::set_image`]).
            ///
            /// # Errors
            #[doc = concat!(
                "As for [`Solver::", stringify!($create), "`], or if a handle is null, or a buffer is too small, as far as its \
                 memory requirements show that.",
            )]
            pub fn $create_into(
                &self,
                device: &ash::Device,
                allocator: &mut dyn DeviceMemory,
                surface: &FrameSurface,
                $($room: $kind,)?
                $hosts: $of,
            ) -> Result<$output, VulkanError> {
                let made = make(device, (self, surface), $($room)?)?;
                let hosts = Some(HostMemory::$memory($hosts));
                Output::new(device, allocator, (self, surface), made, hosts)
            }
        }
    };
}
pub(super) use creation;
