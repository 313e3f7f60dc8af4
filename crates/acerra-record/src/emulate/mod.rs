//! Instruments emulated on the loopback interface, speaking their protocols byte for byte.

mod channel;
mod emulated_radio;
mod marks;
mod no_fix;
mod numbering;
mod options;
mod pps;
mod pulse_line;
mod radio;
mod receiver;
mod server;
mod solutions;
mod source;
mod world;

pub use channel::{Channel, ChannelCounts, Impairments};
pub use emulated_radio::EmulatedRadio;
pub use options::{EmulatorCounts, EmulatorOptions};
pub use pps::{EmulatedPps, PpsOptions};
pub use pulse_line::{LatestEdge, PulseLine};
pub use radio::{Effect, RadioState};
pub use receiver::{EmulatedReceiver, ReceiverOptions};
pub use solutions::{Quality, with_solutions};
pub use source::{Pattern, Recorded, ScanSource, SourceError, SourceScan};
pub use world::World;
