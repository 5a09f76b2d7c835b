//! Numbers of which a factor consists, and vector registers of them.

use faer::traits::ComplexField;
use pulp::Simd;

/// Numbers of which a factor may consist.
pub(in crate::reduction) trait Entry:
    ComplexField
    + Copy
    + Default
    + Send
    + Sync
    + std::ops::Mul<Output = Self>
    + std::ops::MulAssign
    + std::ops::AddAssign
{
    /// One unknown of all right-hand sides.
    type Row: Copy + Send + Sync + AsMut<[Self]> + AsRef<[Self]>;
    /// A vector register.
    type Register<S: Simd>: Copy;
    /// Right-hand sides solved for at once.
    const WIDTH: usize;
    /// Right-hand sides that vanish.
    const ZERO_ROW: Self::Row;
    const ZERO: Self;
    const ONE: Self;
    const MINUS_ONE: Self;

    /// Whether it can be a pivot of a positive definite matrix: positive and finite.
    fn is_positive(self) -> bool;
    fn is_negative(self) -> bool;
    /// Root of the magnitude, with the sign.
    fn signed_root(self) -> Self;

    fn inverse(self) -> Self;
    /// A row as vector registers; their number of lanes divides its length.
    fn lanes<S: Simd>(row: &Self::Row) -> &[Self::Register<S>];
    fn lanes_mut<S: Simd>(row: &mut Self::Row) -> &mut [Self::Register<S>];
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Register<S>;
    /// `sum - a b`.
    fn sub_mul<S: Simd>(
        simd: S,
        a: Self::Register<S>,
        b: Self::Register<S>,
        sum: Self::Register<S>,
    ) -> Self::Register<S>;
}

macro_rules! entry {
    ($number:ty, $width:literal, $register:ident, $lanes:ident, $lanes_mut:ident, $splat:ident, $mul_add:ident, $neg:ident) => {
        impl Entry for $number {
            type Row = [$number; $width];
            type Register<S: Simd> = S::$register;
            const WIDTH: usize = $width;
            const ZERO_ROW: Self::Row = [0.0; $width];
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const MINUS_ONE: Self = -1.0;

            fn is_positive(self) -> bool {
                self > 0.0 && self.is_finite()
            }

            fn is_negative(self) -> bool {
                self < 0.0
            }

            fn signed_root(self) -> Self {
                self.abs().sqrt().copysign(self)
            }

            #[inline(always)]
            fn inverse(self) -> Self {
                1.0 / self
            }

            #[inline(always)]
            fn lanes<S: Simd>(row: &Self::Row) -> &[S::$register] {
                S::$lanes(row).0
            }

            #[inline(always)]
            fn lanes_mut<S: Simd>(row: &mut Self::Row) -> &mut [S::$register] {
                S::$lanes_mut(row).0
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$register {
                simd.$splat(value)
            }

            #[inline(always)]
            fn sub_mul<S: Simd>(
                simd: S,
                a: S::$register,
                b: S::$register,
                sum: S::$register,
            ) -> S::$register {
                simd.$mul_add(simd.$neg(a), b, sum)
            }
        }
    };
}

entry!(f64, 8, f64s, as_simd_f64s, as_mut_simd_f64s, splat_f64s, mul_add_f64s, neg_f64s);
entry!(f32, 8, f32s, as_simd_f32s, as_mut_simd_f32s, splat_f32s, mul_add_f32s, neg_f32s);
