//! Features that the wheel and the rest of the workspace have in common, so that both share what is compiled.
//! Its manifest is all there is: the practice of `cargo hakari`.
