//! Hertz's closed forms.
