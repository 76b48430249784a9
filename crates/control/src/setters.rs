//! One setter for each option, so that new options do not break programs that set some of them.

/// Adds a setter method for each field of an options struct.
macro_rules! setters {
    ({$($generics:tt)*} $options:ty; $($field:ident: $type:ty,)*) => {
        impl<$($generics)*> $options {$(
            #[doc = concat!("Sets [`", stringify!($field), "`](Self#structfield.", stringify!($field), ").")]
            #[must_use]
            pub fn $field(mut self, $field: $type) -> Self {
                self.$field = $field;
                self
            }
        )*}
    };
}
pub(crate) use setters;
