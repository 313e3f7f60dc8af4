//! Instruments emulated on the loopback interface, speaking their protocols byte for byte.

mod channel;
mod radio;
mod receiver;
mod server;
mod source;
mod world;

pub use channel::{Channel, ChannelCounts, Impairments};
pub use radio::{Effect, RadioState};
pub use receiver::{EmulatedReceiver, ReceiverOptions};
pub use server::{EmulatedRadio, EmulatorCounts, EmulatorOptions};
pub use source::{Pattern, Recorded, ScanSource, SourceError, SourceScan};
pub use world::World;
