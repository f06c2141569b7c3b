//! Whether a `repr(C)` struct and its WGSL twin have the same layout.

/// Asserts that `$type` has the size of the struct of the same name in the program
/// `$source`, and that each field listed lies where it lies there.
///
/// Fields of the Rust struct that are padding are left out; the WGSL struct may have
/// no others than those listed.
#[macro_export]
macro_rules! assert_layout {
    ($source:expr, $type:ident { $($field:ident),+ $(,)? }) => {
        $crate::layout::check(
            $source,
            stringify!($type),
            size_of::<$type>(),
            &[$((stringify!($field), core::mem::offset_of!($type, $field))),+],
        )
    };
}

/// The check that [`assert_layout!`] calls.
///
/// # Panics
/// If the program is invalid, has no such struct, or lays it out differently.
pub fn check(source: &str, name: &str, size: usize, fields: &[(&str, usize)]) {
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
    let twin = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name));
    let Some((_, twin)) = twin else {
        panic!("the program has no struct {name}");
    };
    let naga::TypeInner::Struct { members, span } = &twin.inner else {
        panic!("{name} is no struct in WGSL");
    };
    let there: Vec<(&str, usize)> = members
        .iter()
        .map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize))
        .collect();
    assert_eq!(
        fields, there,
        "fields and offsets of {name}, Rust against WGSL"
    );
    assert_eq!(size, *span as usize, "size of {name}, Rust against WGSL");
}
