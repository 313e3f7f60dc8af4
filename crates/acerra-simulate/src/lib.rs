//! Simulation of whole campaigns: the logs that the instruments would have written.
//!
//! `acerra simulate SCENE.toml -o DIR` reads a scene file ([`scene::Scene`]) and writes the radar's
//! capture, the GNSS logs of rover and base as RINEX 2.11 and as UBX (RXM-RAW, RXM-SFRB) and a
//! navigation file, the campaign file that processes them, the scene itself, and the truth. Without `[gnss]`
//! the true trajectory takes the place of the GNSS logs. Equal scenes and seeds give equal bytes. A scene with
//! every section, most keys at their defaults:
//!
//! ```
//! let scene = acerra_simulate::scene::Scene::parse(r#"
//! seed = 7
//! origin_deg_m = [40.9596, 14.3696, 75.0]
//! base_m = [-12.0, -8.0, 1.5]            # position of the base's antenna: east, north, up
//! start_gpst = [2019, 10, 15, 9, 30, 0]
//! record = "track"                       # what the radar logs; or "flight", with take-off
//!
//! [flight]                               # flown by hand; or [trajectory] file = "flown.csv"
//! track_start_m = [0.0, -2.0]
//! track_end_m = [33.0, -2.0]
//! height_m = 10.0
//! track_duration_s = 21.7
//! wander_m = [0.12, 0.12, 0.06]          # along, across, up, forgotten within …
//! wander_time_s = 1.8
//! tilt_deg = [1.5, 1.5, 3.0]             # roll, pitch, heading
//! ground_time_s = 90.0                   # before take-off and after landing
//! climb_m_s = 1.0
//!
//! [radar]                                # a PulsON P440
//! band_ghz = [3.1, 4.8]
//! band_taper = 0.1
//! scan_interval_s = 0.07                 # 14.28 Hz
//! samples = 1824                         # a multiple of 96, 61.035 ps apart
//! integration_index = 11                 # PII: 2¹¹ pulses in each sample
//! transmit_power_dbm = -13.0
//! transmit_gain_index = 63
//! antenna_gain_dbi = 6.0
//! antenna_beamwidth_deg = 90.0
//! noise_figure_db = 5.0
//! noise_counts = 20.0
//! dynamic_range_db = 75.0                # larger counts are clipped
//! coupling_db = 40.0                     # antenna to antenna, constant over the traces
//! delay_ns = 10.0                        # cables, antennas: what zero-timing takes out
//! timing_jitter_ps = 0.5
//! lost_packets = 0.002
//! lever_arm_m = [0.05, 0.0, -0.2]        # forward, left, up of the GNSS antenna
//!
//! [ground]                               # z = 0
//! reflection = 0.08                      # of the mirror-like echo straight below
//! backscatter_db = -28.0                 # roughness: facets of random phase, thus speckle
//! facets_per_m2 = 4.0
//! extent_m = 12.0
//!
//! [[corner]]                             # a trihedral: bell of half power at 20° off its axis
//! position_m = [4.0, 0.0, 0.0]
//! edge_m = 0.4
//! azimuth_deg = 180.0                    # looks south and up, towards the track
//! elevation_deg = 75.0
//!
//! [[point]]
//! position_m = [14.0, 0.0, 0.0]
//! rcs_m2 = 1.0
//!
//! [[clutter]]                            # an awning: a box of scatterers
//! from_m = [2.0, 10.4, 0.5]
//! to_m = [16.0, 12.0, 3.0]
//! scatterers = 250
//! rcs_m2 = 400.0
//!
//! [gnss]                                 # two LEA-6T
//! elevation_mask_deg = 10.0
//! ionosphere_scale = 1.0
//! humidity = 0.5
//! # navigation = "brdc.19n"              # the day's satellites, instead of made-up ones
//! [gnss.rover]
//! interval_s = 0.2
//! clock_offset_s = 2.3e-4
//! clock_drift = 2.4e-7
//! code_noise_m = 0.35                    # at the zenith; grows towards the horizon
//! phase_noise_m = 0.0015
//! code_multipath_m = 1.0                 # at the horizon; falls towards the zenith
//! phase_multipath_m = 0.003
//! multipath_time_s = 8.0
//! slips_per_hour = 2.0
//! half_cycle_time_s = [2.0, 8.0]         # half cycles not resolved so long after acquisition
//! blockages_per_hour = 1.0               # one satellite hidden
//! blockage_time_s = 3.0
//! outages_s = [[20.0, 22.5]]             # all of them lost
//! [gnss.base]
//! clock_offset_s = -1.7e-4
//! multipath_time_s = 60.0
//!
//! [image]                                # what the campaign file that is written asks for
//! x_m = [0.0, 18.0]
//! y_m = [-9.0, 9.0]
//! pixel_m = 0.01
//! "#)?;
//! assert_eq!((scene.corner.len(), scene.point.len(), scene.clutter.len()), (1, 1, 1));
//! # Ok::<(), acerra_simulate::scene::SceneError>(())
//! ```

pub mod demo;
pub mod flight;
pub mod gnss;
pub mod radar;
pub mod scene;
pub mod write;
