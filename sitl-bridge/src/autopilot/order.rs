//! Orders that end a flight, and what becomes of them.

/// An order of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Return to launch.
    Return,
    /// Land at the present position.
    Land,
}

/// What became of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordered {
    /// It is commanded.
    Commanded,
    /// It will be, once a heartbeat tells that the vehicle is the node's.
    Waits,
    /// It is not: the vehicle is disarmed, or somebody else's.
    Refused,
}

/// An order that waits for a heartbeat, and until when; `None`: for the first.
pub(super) type WaitingOrder = (Order, Option<i64>);
