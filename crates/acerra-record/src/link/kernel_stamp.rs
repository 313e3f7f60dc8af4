//! Times of reception by the kernel, and how they are put on the host's monotonic clock.
//!
//! The kernel stamps datagrams by the calendar clock, which may be stepped. The waiting time of a datagram is
//! the difference of two readings of that clock; the host clock less the waiting time is the time of
//! reception. Where the calendar clock was stepped meanwhile, stamps are not used.

use std::io;
use std::net::UdpSocket;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::host::HostClock;

/// Longest time that a datagram waits for this program; a longer one is a step of the calendar clock.
const LONGEST_WAIT: Duration = Duration::from_secs(10);
/// Change of the calendar clock against the host clock that exceeds slewing: a step, and the largest share of
/// the time between two readings by slewing (1 in 1000 is twice what systems do).
const STEP_NS: i64 = 1_000_000;
const SLEW_DIVISOR: u64 = 1_000;
/// Time after a step for which datagrams stamped before it may still wait, ns.
const DISTRUST_NS: u64 = 2_000_000_000;

/// A datagram that was received.
pub(super) struct Datagram {
    /// Length.
    pub bytes: usize,
    /// The kernel's stamp, since 1970.
    pub stamp: Option<Duration>,
}

/// Enables the kernel's stamps; `false` where the kernel has none.
#[cfg(target_os = "linux")]
pub(super) fn enable(socket: &UdpSocket) -> bool {
    use nix::sys::socket::{setsockopt, sockopt::ReceiveTimestampns};
    setsockopt(socket, ReceiveTimestampns, &true).is_ok()
}

/// Enables the kernel's stamps: only Linux has them.
#[cfg(not(target_os = "linux"))]
pub(super) fn enable(_: &UdpSocket) -> bool {
    false
}

/// Receives a datagram with its stamp, where there is one.
#[cfg(target_os = "linux")]
pub(super) fn receive(socket: &UdpSocket, buffer: &mut [u8]) -> io::Result<Datagram> {
    use nix::sys::socket::{ControlMessageOwned, MsgFlags, recvmsg};
    use nix::sys::time::TimeSpec;
    use std::os::fd::AsRawFd;
    let mut control = nix::cmsg_space!(TimeSpec);
    let mut parts = [io::IoSliceMut::new(buffer)];
    let received = recvmsg::<()>(
        socket.as_raw_fd(),
        &mut parts,
        Some(&mut control),
        MsgFlags::empty(),
    )?;
    let stamp = received.cmsgs()?.find_map(|message| match message {
        ControlMessageOwned::ScmTimestampns(time) => {
            let seconds = u64::try_from(time.tv_sec()).ok()?;
            Some(Duration::new(seconds, u32::try_from(time.tv_nsec()).ok()?))
        }
        _ => None,
    });
    Ok(Datagram {
        bytes: received.bytes,
        stamp,
    })
}

/// Receives a datagram.
#[cfg(not(target_os = "linux"))]
pub(super) fn receive(socket: &UdpSocket, buffer: &mut [u8]) -> io::Result<Datagram> {
    socket
        .recv(buffer)
        .map(|bytes| Datagram { bytes, stamp: None })
}

/// Puts stamps of the calendar clock on the host clock, as long as that is not stepped.
#[derive(Debug, Clone, Default)]
pub(crate) struct StampPairing {
    /// Host clock and calendar clock less host clock when they were last read, ns.
    last: Option<(u64, i64)>,
    /// Host clock until which stamps are not used, ns.
    distrusted_until_ns: u64,
}

impl StampPairing {
    /// The host clock at a stamp, ns; `None` where the clocks do not determine it.
    pub fn host_ns(&mut self, clock: HostClock, stamp: Duration) -> Option<u64> {
        let calendar = SystemTime::now().duration_since(UNIX_EPOCH).ok()?;
        self.host_ns_at(clock.now_ns(), calendar, stamp)
    }

    /// As above, with both clocks read together: `host_ns` and `calendar`.
    pub fn host_ns_at(&mut self, host_ns: u64, calendar: Duration, stamp: Duration) -> Option<u64> {
        let calendar_ns = i64::try_from(calendar.as_nanos()).ok()?;
        let ahead_ns = calendar_ns - i64::try_from(host_ns).ok()?;
        let is_stepped = self.last.is_some_and(|(before_ns, before)| {
            let slewed_ns = host_ns.saturating_sub(before_ns) / SLEW_DIVISOR;
            ahead_ns.abs_diff(before) > STEP_NS as u64 + slewed_ns
        });
        self.last = Some((host_ns, ahead_ns));
        if is_stepped {
            self.distrusted_until_ns = host_ns + DISTRUST_NS;
        }
        let waited = calendar.checked_sub(stamp)?;
        let waited_ns = u64::try_from(waited.as_nanos()).ok()?;
        (host_ns >= self.distrusted_until_ns && waited <= LONGEST_WAIT)
            .then(|| host_ns.saturating_sub(waited_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEGAN: Duration = Duration::from_secs(1_700_000_000);

    #[test]
    fn the_wait_is_taken_off_and_stamps_about_a_step_are_not_used() {
        let mut pairing = StampPairing::default();
        let second = 1_000_000_000_u64;
        let at = |s: f64| BEGAN + Duration::from_secs_f64(s);
        assert_eq!(
            pairing.host_ns_at(5 * second, at(5.0), at(4.5)),
            Some(4_500_000_000)
        );
        // Slewed by 0.3 ms in a second.
        assert!(
            pairing
                .host_ns_at(6 * second, at(6.0003), at(6.0))
                .is_some()
        );
        // Set forward by an hour: datagrams stamped before seem to have waited for long, and all stamps are
        // doubted for a while.
        assert_eq!(pairing.host_ns_at(7 * second, at(3607.0), at(6.9)), None);
        assert_eq!(pairing.host_ns_at(8 * second, at(3608.0), at(3607.9)), None);
        assert_eq!(
            pairing.host_ns_at(10 * second, at(3610.0), at(3609.9)),
            Some(9_900_000_000)
        );
        // A stamp of the future.
        assert_eq!(
            pairing.host_ns_at(11 * second, at(3611.0), at(3611.1)),
            None
        );
    }

    #[test]
    fn a_datagram_that_waited_is_stamped_when_it_came() {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        if !enable(&socket) {
            return;
        }
        let clock = HostClock::start();
        let mut pairing = StampPairing::default();
        let mut buffer = [0; 16];
        // A datagram that comes before the kernel has begun to stamp is stamped when it is read.
        let waits_are_seen = (0..20).any(|_| {
            let before_ns = clock.now_ns();
            let own = socket.local_addr().unwrap();
            socket.send_to(b"scan", own).unwrap();
            std::thread::sleep(Duration::from_millis(100));
            let datagram = receive(&socket, &mut buffer).unwrap();
            assert_eq!(&buffer[..datagram.bytes], b"scan");
            let stamp = datagram.stamp.expect("a stamp of the kernel");
            let came_ns = pairing.host_ns(clock, stamp).expect("no step of the clock");
            assert!(came_ns + 1_000_000 >= before_ns, "{came_ns} {before_ns}");
            came_ns < before_ns + 50_000_000
        });
        assert!(waits_are_seen);
    }
}
