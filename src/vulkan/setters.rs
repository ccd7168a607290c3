//! Defines the methods that set a public field of a struct of parameters.

/// Defines methods that return the value with another field: `with_slot(slot: usize);` sets the field `slot`.
macro_rules! setters {
    ($($with:ident($field:ident: $kind:ty);)*) => {$(
        #[doc = concat!("Sets the field `", stringify!($field), "`.")]
        pub fn $with(self, $field: $kind) -> Self {
            Self { $field, ..self }
        }
    )*};
}
pub(crate) use setters;
