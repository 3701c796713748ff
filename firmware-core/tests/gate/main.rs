//! The safety gate through its public interface: every cause with its action and its time, the fence under a
//! hostile actor, random sequences of inputs against plain rules, and the table of `docs/safety.md`.

mod bench;
mod causes;
mod fence;
mod flight;
mod numbers;
mod rules;
mod table;
