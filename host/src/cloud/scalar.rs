//! The number types of PLY and PCD and how their bytes become a value.

/// A number type; all of them fit an `f64`, the 64-bit integers after rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// Which end of a number is stored first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

impl Scalar {
    /// Bytes of one number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether the type is for whole numbers.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The value of `size()` bytes.
    pub(super) fn value(self, bytes: &[u8], order: ByteOrder) -> f64 {
        let mut word = [0; 8];
        let size = self.size();
        for (slot, &byte) in word.iter_mut().zip(&bytes[..size]) {
            *slot = byte;
        }
        if order == ByteOrder::Big {
            word[..size].reverse();
        }
        let word = u64::from_le_bytes(word);
        match self {
            Self::I8 => f64::from(word as i8),
            Self::U8 => f64::from(word as u8),
            Self::I16 => f64::from(word as i16),
            Self::U16 => f64::from(word as u16),
            Self::I32 => f64::from(word as i32),
            Self::U32 => f64::from(word as u32),
            Self::I64 => word as i64 as f64,
            Self::U64 => word as f64,
            Self::F32 => f64::from(f32::from_bits(word as u32)),
            Self::F64 => f64::from_bits(word),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_of_every_type() {
        let cases: [(Scalar, &[u8], f64); 10] = [
            (Scalar::I8, &(-2_i8).to_le_bytes(), -2.0),
            (Scalar::U8, &254_u8.to_le_bytes(), 254.0),
            (Scalar::I16, &(-300_i16).to_le_bytes(), -300.0),
            (Scalar::U16, &65_000_u16.to_le_bytes(), 65_000.0),
            (Scalar::I32, &(-70_000_i32).to_le_bytes(), -70_000.0),
            (Scalar::U32, &4_000_000_000_u32.to_le_bytes(), 4.0e9),
            (Scalar::I64, &(-5_000_000_000_i64).to_le_bytes(), -5.0e9),
            (Scalar::U64, &5_000_000_000_u64.to_le_bytes(), 5.0e9),
            (Scalar::F32, &(-0.1_f32).to_le_bytes(), f64::from(-0.1_f32)),
            (Scalar::F64, &0.1_f64.to_le_bytes(), 0.1),
        ];
        for (scalar, bytes, expected) in cases {
            assert_eq!(scalar.size(), bytes.len());
            assert_eq!(scalar.value(bytes, ByteOrder::Little), expected, "{scalar:?}");
            let mut reversed = bytes.to_vec();
            reversed.reverse();
            assert_eq!(scalar.value(&reversed, ByteOrder::Big), expected, "{scalar:?}");
        }
    }
}
