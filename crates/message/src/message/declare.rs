//! The single declaration of a message. It generates the struct, an empty value, the layout and the
//! visitors.

/// Declares a message. Each field has a type, a value in an empty message, and a meaning: `number`,
/// `flag`, `ends`, `code(Status)`, `count(of this list)`, `hidden(points)`, `points(accessor)`,
/// `list(accessor)` of numbers, `message`, `messages(accessor)`, or `reserved`. An accessor is the
/// method that returns the valid part of a list.
macro_rules! message {
    (
        $(#[$attribute:meta])*
        pub struct $type:ident = $type_name:literal {
            $($(#[doc = $about:literal])+ $field:ident: $of:ty = $empty:expr => $kind:ident $(($($argument:tt)+))?,)+
        }
    ) => {
        $(#[$attribute])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[cfg_attr(feature = "transport", derive(ZeroCopySend), type_name($type_name))]
        pub struct $type {
            $($(#[doc = $about])+ pub $field: $of,)+
        }

        impl $type {
            /// An empty message.
            pub const EMPTY: Self = Self { $($field: $empty,)+ };

            /// The fields and their offsets.
            pub const LAYOUT: $crate::fields::Layout = $crate::fields::Layout {
                name: stringify!($type),
                type_name: $type_name,
                size: size_of::<Self>(),
                fields: &[$($crate::fields::Field {
                    name: stringify!($field),
                    about: concat!($($about),+),
                    offset: std::mem::offset_of!(Self, $field),
                    of: <$of as $crate::fields::Typed>::TYPE,
                    meaning: meaning!($kind $($($argument)+)?),
                },)+],
            };
        }

        impl Default for $type {
            fn default() -> Self {
                Self::EMPTY
            }
        }

        impl $crate::fields::Typed for $type {
            const TYPE: $crate::fields::Type = $crate::fields::Type::Message(&Self::LAYOUT);
        }

        impl $crate::fields::Message for $type {
            fn layout(&self) -> &'static $crate::fields::Layout {
                &Self::LAYOUT
            }

            fn visit<'a>(&'a self, see: &mut dyn FnMut(&'static $crate::fields::Field, $crate::fields::Value<'a>)) {
                let mut fields = Self::LAYOUT.fields.iter();
                $(if let Some(field) = fields.next() {
                    see_field!(self, see, field, $field, $kind $($($argument)+)?);
                })+
            }

            fn visit_mut(&mut self, see: &mut dyn FnMut(&'static $crate::fields::Field, $crate::fields::Place<'_>)) {
                let mut fields = Self::LAYOUT.fields.iter();
                $(if let Some(field) = fields.next() {
                    see_place!(self, see, field, $field, $kind);
                })+
            }
        }
    };
}

macro_rules! meaning {
    (number) => {
        $crate::fields::Meaning::Number
    };
    (flag) => {
        $crate::fields::Meaning::Flag
    };
    (ends) => {
        $crate::fields::Meaning::Ends
    };
    (code $codes:ident) => {
        $crate::fields::Meaning::Code(&$crate::$codes::CODES)
    };
    (count $list:ident) => {
        $crate::fields::Meaning::Count(stringify!($list))
    };
    (hidden $points:ident) => {
        $crate::fields::Meaning::Hidden
    };
    (points $accessor:ident) => {
        $crate::fields::Meaning::Points
    };
    (list $accessor:ident) => {
        $crate::fields::Meaning::List
    };
    (message) => {
        $crate::fields::Meaning::Message
    };
    (messages $accessor:ident) => {
        $crate::fields::Meaning::Messages
    };
    (reserved) => {
        $crate::fields::Meaning::Reserved
    };
}

macro_rules! see_field {
    ($self:ident, $see:ident, $field:ident, $name:ident, reserved) => {
        let _ = $field;
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, message) => {
        $see($field, $crate::fields::Value::Message(&$self.$name))
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, messages $accessor:ident) => {
        $see(
            $field,
            $crate::fields::Value::Messages($crate::fields::Messages::of(
                &$self.$name,
                $self.$accessor().len(),
            )),
        )
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, hidden $points:ident) => {
        $see(
            $field,
            $crate::fields::Value::Hidden(&$self.$name, $self.$points().len()),
        )
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, points $accessor:ident) => {
        $see($field, $self.$accessor().into())
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, list $accessor:ident) => {
        $see($field, $self.$accessor().into())
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, $kind:ident $($argument:tt)*) => {
        $see($field, $self.$name.into())
    };
}

macro_rules! see_place {
    ($self:ident, $see:ident, $field:ident, $name:ident, reserved) => {
        let _ = $field;
        $self.$name = Default::default();
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, message) => {
        $see($field, $crate::fields::Place::Message(&mut $self.$name))
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, messages) => {
        $see($field, $crate::fields::Place::Messages(&mut $self.$name))
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, hidden) => {
        $see($field, $crate::fields::Place::Hidden(&mut $self.$name))
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, points) => {
        $see($field, $self.$name.as_mut_slice().into())
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, list) => {
        $see($field, $self.$name.as_mut_slice().into())
    };
    ($self:ident, $see:ident, $field:ident, $name:ident, $kind:ident) => {
        $see($field, (&mut $self.$name).into())
    };
}
