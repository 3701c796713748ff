//! The parameter protocol: reading single parameters of an autopilot by their names.

use super::fields::{Fields, Payload};
use super::id;

/// Length of a parameter's name on the wire, bytes.
const NAME: usize = 16;

/// PARAM_REQUEST_READ (20): asks for a parameter by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParamRequestRead {
    /// The parameter's name, ASCII, 16 characters at most.
    pub name: &'static str,
}

impl ParamRequestRead {
    /// The payload for this (system, component).
    #[must_use]
    pub fn payload(&self, target: (u8, u8)) -> Payload {
        let mut payload = Payload::new(id::PARAM_REQUEST_READ);
        // No index: the name counts.
        payload.put(&(-1i16).to_le_bytes());
        payload.put(&[target.0, target.1]);
        let mut name = [0; NAME];
        for (out, &byte) in name.iter_mut().zip(self.name.as_bytes()) {
            *out = byte;
        }
        payload.put(&name);
        payload
    }
}

/// PARAM_VALUE (22).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterValue {
    /// The parameter's name.
    pub name: String,
    /// `param_value`: the four bytes as they came. What they mean depends on the autopilot.
    pub bytes: [u8; 4],
    /// MAV_PARAM_TYPE.
    pub kind: u8,
}

impl ParameterValue {
    /// Reads the fields of a payload.
    pub(super) fn read(fields: Fields<'_>) -> Self {
        let name = fields.get::<NAME>(8);
        let end = name.iter().position(|&byte| byte == 0).unwrap_or(NAME);
        let name = name[..end].iter().map(|&byte| if byte.is_ascii_graphic() { char::from(byte) } else { '?' });
        Self { name: name.collect(), bytes: fields.get(0), kind: fields.u8(24) }
    }

    /// The number where integers were cast to a float, as ArduPilot does.
    #[must_use]
    pub const fn cast(&self) -> f64 {
        f32::from_le_bytes(self.bytes) as f64
    }

    /// The number where the bytes are those of the parameter's own type, as PX4 sends them.
    #[must_use]
    pub const fn bytewise(&self) -> f64 {
        let [first, second, ..] = self.bytes;
        // MAV_PARAM_TYPE: UINT8 to INT32.
        match self.kind {
            1 => first as f64,
            2 => i8::from_le_bytes([first]) as f64,
            3 => u16::from_le_bytes([first, second]) as f64,
            4 => i16::from_le_bytes([first, second]) as f64,
            5 => u32::from_le_bytes(self.bytes) as f64,
            6 => i32::from_le_bytes(self.bytes) as f64,
            _ => self.cast(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: [u8; 4], name: &[u8], kind: u8) -> ParameterValue {
        let mut payload = [&bytes[..], &[0; 4], name].concat();
        payload.resize(24, 0);
        payload.push(kind);
        ParameterValue::read(Fields(&payload))
    }

    #[test]
    fn integers_are_read_as_each_autopilot_writes_them() {
        let cast = read(5f32.to_le_bytes(), b"FS_GCS_ENABLE", 2);
        assert_eq!((cast.name.as_str(), cast.cast()), ("FS_GCS_ENABLE", 5.0));
        let bytewise = read(5i32.to_le_bytes(), b"COM_OBL_RC_ACT", 6);
        assert_eq!((bytewise.bytewise(), bytewise.cast() < 1e-40), (5.0, true));
        assert_eq!(read((-1i32).to_le_bytes(), b"A", 6).bytewise(), -1.0);
        assert_eq!(read(1.5f32.to_le_bytes(), b"COM_OF_LOSS_T", 9).bytewise(), 1.5);
    }

    #[test]
    fn a_name_may_fill_its_field_and_hold_anything() {
        assert_eq!(read([0; 4], b"ABCDEFGHIJKLMNOP", 9).name, "ABCDEFGHIJKLMNOP");
        assert_eq!(read([0; 4], b"A\x1b\xffB", 9).name, "A??B");
    }

    #[test]
    fn a_request_names_its_parameter() {
        let payload = ParamRequestRead { name: "GUID_TIMEOUT" }.payload((7, 1));
        assert_eq!(payload.bytes(), [&[0xff, 0xff, 7, 1][..], b"GUID_TIMEOUT\0\0\0\0"].concat());
    }
}
