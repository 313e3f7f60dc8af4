//! Messages of ROS 2 as DDS serialises them: Common Data Representation, plain, version 1 (OMG DDSI-RTPS
//! 2.3, clause 10; CORBA 3.0, clause 15.3).
//!
//! Four bytes give the byte order; then each number is at a multiple of its own length, counted from the end
//! of the byte order.

use crate::bytes::array;

/// Reads the fields of a message one behind the other.
#[derive(Debug, Clone)]
pub struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    is_little: bool,
}

impl<'a> Cdr<'a> {
    /// The fields of a message; none of an encoding that is not known.
    pub fn new(message: &'a [u8]) -> Option<Self> {
        let is_little = match array(message, 0)? {
            [0, 0, _, _] => false,
            [0, 1, _, _] => true,
            _ => return None,
        };
        Some(Self {
            bytes: message.get(4..)?,
            at: 0,
            is_little,
        })
    }

    fn next<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.at = self.at.next_multiple_of(N);
        let mut bytes: [u8; N] = array(self.bytes, self.at)?;
        self.at += N;
        if !self.is_little {
            bytes.reverse();
        }
        Some(bytes)
    }

    /// A byte.
    pub fn u8(&mut self) -> Option<u8> {
        self.next::<1>().map(|[byte]| byte)
    }

    /// A whole number of 16 bits without sign.
    pub fn u16(&mut self) -> Option<u16> {
        self.next().map(u16::from_le_bytes)
    }

    /// A whole number of 32 bits without sign.
    pub fn u32(&mut self) -> Option<u32> {
        self.next().map(u32::from_le_bytes)
    }

    /// A whole number of 32 bits with sign.
    pub fn i32(&mut self) -> Option<i32> {
        self.next().map(i32::from_le_bytes)
    }

    /// A number in double precision.
    pub fn f64(&mut self) -> Option<f64> {
        self.next().map(f64::from_le_bytes)
    }

    /// `N` numbers in double precision.
    pub fn f64s<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Some(values)
    }

    /// Goes past a text: its length with the zero at its end, and its bytes.
    pub fn skip_text(&mut self) -> Option<()> {
        let length = usize::try_from(self.u32()?).ok()?;
        let end = self.at.checked_add(length)?;
        self.bytes.get(self.at..end)?;
        self.at = end;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_at_multiples_of_their_length_in_either_byte_order() {
        let mut little = vec![0, 1, 0, 0];
        little.extend([7, 0, 0, 0]);
        little.extend(3_u32.to_le_bytes());
        little.extend(b"ab\0\0\0\0\0\0");
        little.extend((-1.5_f64).to_le_bytes());
        let mut cdr = Cdr::new(&little).unwrap();
        assert_eq!(cdr.u8(), Some(7));
        assert_eq!(cdr.skip_text(), Some(()));
        assert_eq!(cdr.f64(), Some(-1.5));
        assert_eq!(cdr.u8(), None);
        let big = [0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 5];
        let mut cdr = Cdr::new(&big).unwrap();
        assert_eq!((cdr.u16(), cdr.u32()), (Some(9), Some(5)));
        assert!(Cdr::new(&[0, 7, 0, 0, 1]).is_none());
        // A text that claims more than there is.
        let mut cdr = Cdr::new(&[0, 1, 0, 0, 255, 255, 255, 255, 65]).unwrap();
        assert_eq!(cdr.skip_text(), None);
    }
}
