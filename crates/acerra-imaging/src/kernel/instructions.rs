//! Methods of a level's token, each of which is one expression of the level's instructions.

/// Defines methods `fn name(arguments) -> type = expression;` of a token that proves the instructions.
macro_rules! instructions {
    ($(fn $name:ident($($argument:ident: $of:ty),+) -> $out:ty = $body:expr;)+) => {
        $(
            #[inline(always)]
            fn $name(self, $($argument: $of),+) -> $out {
                // SAFETY: `self` proves the instructions.
                unsafe { $body }
            }
        )+
    };
}
pub(super) use instructions;
