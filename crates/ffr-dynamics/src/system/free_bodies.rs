//! Free flexible bodies under force elements.
