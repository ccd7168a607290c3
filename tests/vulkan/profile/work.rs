//! Work of passes, compared with the tests' own counts.

use geosweep::cpu::twins::{ScanOrder, scan_due};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::plan::{Scan, ScanPair, Step};
use geosweep::vulkan::profile::{Detail, Grain, PassKind, PassRecord};
use geosweep::vulkan::{Schedule, TexelChart, Tuning};
use geosweep::{Stop, Wavefront};

use crate::common::{seeds_at, some_point};
use crate::profile::bench::{Bench, method, of_kind, sum};

#[test]
fn texels_visited_and_skipped_are_those_of_the_plan() {
    // The lines of the first two grids fit a workgroup, which takes blocks in turn. Of the third grid, only the lines
    // in one direction fit.
    for (rows, cols) in [(61, 90), (90, 61), (3, 180), (121, 130)] {
        for grain in [Grain::Blocks, Grain::Scans] {
            // A recording has this many iterations.
            for (wavefront, iterations) in [(Wavefront::Planar, 4), (Wavefront::Curved, 5)] {
                let mut bench = Bench::new(rows, cols);
                hold_against_the_plan(&mut bench, grain, wavefront, iterations);
            }
        }
    }
}

#[test]
fn texels_of_pairs_are_those_of_the_plan() {
    for ((rows, cols), grain) in [((61, 90), Grain::Scans), ((121, 130), Grain::Blocks)] {
        let pairs = |old| Tuning { scan_pairs: true, ..old };
        let mut bench = Bench::tuned(rows, cols, pairs);
        hold_against_the_plan(&mut bench, grain, Wavefront::Planar, 4);
    }
}

/// Marks in grids of booleans the texels of every block of the plan that was due according to the twin.
/// Compares the records of the device's passes with the marks, scan by scan or pair by pair. The first
/// iteration must be the same. In later ones, the device rounds some fronts differently from the twin, and a
/// change of the last digit also makes a block due: up to a tenth of the texels may differ.
fn hold_against_the_plan(bench: &mut Bench, grain: Grain, wavefront: Wavefront, iterations: usize) {
    let detail = Detail { grain, ..Detail::default() };
    let method = method(wavefront, Schedule::Raster);
    let profile = bench.profile(method, detail);
    let recordings = of_kind(&profile, PassKind::Count).count() / iterations;
    let (texels, portions) = bench.steps(method, recordings);
    let (height, width) = (texels.inner_rows().len(), texels.inner_cols().len());
    let Tuning { scan_lines: lines, scan_pairs, .. } = bench.solver.tuning();
    let edges = EdgeLengths::<f32>::new(&bench.surface).unwrap();
    let order = if scan_pairs { ScanOrder::InPairs } else { ScanOrder::InTurn };
    let by_blocks = (order, lines as usize);
    let (_, due) = scan_due(&edges, &bench.seeds, wavefront, method.stop, by_blocks, f64::INFINITY);
    // The scans that a record covers: both scans of a pair, or a single one.
    let told: Vec<(PassKind, Vec<Scan>)> = match scan_pairs {
        true => ScanPair::ALL.map(|pair| (PassKind::Pair(pair), pair.scans().into())).into(),
        false => Scan::ALL.map(|scan| (PassKind::Scan(scan), vec![scan])).into(),
    };
    let (mut skipped_by_bounds, mut not_due) = (0, 0);
    let (mut expected, mut different) = (0, 0);
    let mut iteration = 0;
    for step_list in portions {
        // No step follows the last count.
        let iterations = step_list.split(|step| *step == Step::Count);
        for steps in iterations.filter(|steps| !steps.is_empty()) {
            for (kind, scans) in &told {
                let (mut passes, mut visited) = (0, 0);
                for &scan in scans {
                    let mut marks = vec![false; height * width];
                    for pass in steps.iter().filter_map(|step| match step {
                        Step::Scan(pass) if pass.scan == scan => Some(pass),
                        _ => None,
                    }) {
                        passes += 1;
                        for k in 0..pass.lines as i32 {
                            let (dx, dy) = scan.ahead();
                            let line = (pass.line as i32 + k * (dx + dy)) as usize - 1;
                            let block = line / lines as usize;
                            let of_iteration = due.get(iteration as usize);
                            let is_due = of_iteration.is_some_and(|due| due[scan as usize][block]);
                            if !pass.always && !is_due {
                                not_due += u32::from(of_iteration.is_some());
                                continue;
                            }
                            for along in pass.texels.clone() {
                                let along = along as usize - 1;
                                let (row, col) =
                                    if dy != 0 { (line, along) } else { (along, line) };
                                assert!(!marks[row * width + col], "visited twice: {pass:?}");
                                marks[row * width + col] = true;
                            }
                        }
                    }
                    visited += marks.iter().filter(|&&mark| mark).count() as u64;
                }
                let of_scans: Vec<_> = of_kind(&profile, *kind)
                    .filter(|pass| pass.iteration == Some(iteration))
                    .collect();
                let records = if grain == Grain::Blocks { passes } else { 1 };
                assert_eq!(of_scans.len(), records, "{kind:?} of {iteration}");
                let dispatches: u32 = of_scans.iter().map(|pass| pass.dispatches).sum();
                assert_eq!(dispatches as usize, passes);
                let found = sum(&of_scans, |pass| pass.work.texels);
                if iteration == 0 || iteration as usize >= due.len() {
                    assert_eq!(found, visited, "{kind:?} of {iteration}");
                }
                expected += visited;
                different += found.abs_diff(visited);
                let all = (scans.len() * height * width) as u64;
                assert_eq!(sum(&of_scans, |pass| pass.work.skipped), all - found);
                skipped_by_bounds += if iteration == 0 { all - visited } else { 0 };
            }
            iteration += 1;
        }
    }
    assert!(skipped_by_bounds > 0, "the source is in the middle");
    assert!(not_due > 0, "the last iteration changes little");
    assert!(10 * different <= expected, "{different} of {expected} texels");
}

/// A coarser record is the sum of the finer ones, whatever the device has decided in between.
#[test]
fn coarser_records_are_sums_of_finer_ones() {
    let mut bench = Bench::new(61, 90);
    for schedule in Schedule::ALL {
        let finer = [Grain::Iterations, Grain::Scans, Grain::Blocks];
        let records = finer.map(|grain| {
            let detail = Detail { grain, invocations: true, ..Detail::default() };
            let profile = bench.profile(method(Wavefront::Curved, schedule), detail);
            profile.passes().copied().collect::<Vec<_>>()
        });
        let sums = records.each_ref().map(|passes| {
            // Passes of an iteration are consecutive, and so are those outside of iterations.
            let iterations = passes.chunk_by(|a, b| a.iteration == b.iteration);
            let sums = iterations.map(|passes| {
                let all: Vec<_> = passes.iter().filter(|pass| pass.area.is_some()).collect();
                let groups = |pass: &PassRecord| pass.groups.map(|g| g.iter().product::<u32>());
                let mut groups: u64 = passes.iter().filter_map(groups).map(u64::from).sum::<u64>();
                // Two kinds of passes are dispatched beyond convergence: the count that ends an iteration,
                // and scans that take blocks in turn. The record of such an iteration says that it was idle.
                let beyond =
                    |pass: &PassRecord| pass.kind == PassKind::Count && moved(pass) == Some((4, 0));
                if passes.iter().any(beyond) {
                    groups = 0;
                }
                [
                    passes.iter().map(|pass| u64::from(pass.dispatches)).sum(),
                    groups,
                    sum(&all, |pass| pass.work.texels),
                    sum(&all, |pass| pass.work.skipped),
                    passes.iter().filter_map(|pass| pass.work.bytes()).sum(),
                    sum(&all, |pass| pass.work.triangles.or(Some(0))),
                    passes.iter().map(|pass| pass.invocations.unwrap_or(0)).sum(),
                ]
            });
            sums.collect::<Vec<_>>()
        });
        assert_eq!(sums[0], sums[1], "{schedule}");
        assert_eq!(sums[1], sums[2], "{schedule}");
        portions_are_sums(&mut bench, schedule, &records[0]);
        let counts = records.each_ref().map(Vec::len);
        assert!(counts.is_sorted(), "{schedule}: {counts:?}");
        let iterations = of_iterations(&records[0]);
        let done = bench.iterations(method(Wavefront::Curved, schedule));
        assert_eq!(iterations, if schedule == Schedule::Tiles { 0 } else { done });
    }
}

/// Asserts that a record of a portion is the sum of its iterations, or rounds, and of the passes before them.
fn portions_are_sums(bench: &mut Bench, schedule: Schedule, of_iterations: &[PassRecord]) {
    let detail = Detail { grain: Grain::Portions, invocations: true, ..Detail::default() };
    let profile = bench.profile(method(Wavefront::Curved, schedule), detail);
    let portions: Vec<_> = of_kind(&profile, PassKind::Portion).collect();
    assert_eq!(portions.len(), profile.submissions.len() - 1, "all but the read-back");
    let visits: Vec<_> = of_iterations.iter().filter(|pass| pass.area.is_some()).collect();
    for of in [
        |pass: &PassRecord| pass.work.texels,
        |pass: &PassRecord| pass.work.skipped,
        |pass: &PassRecord| pass.work.triangles.or(Some(0)),
    ] {
        assert_eq!(sum(&portions, of), sum(&visits, of), "{schedule}");
    }
    let inside: Vec<_> = of_iterations.iter().filter(|p| p.kind != PassKind::Unpack).collect();
    let bytes = |pass: &&PassRecord| pass.work.bytes().unwrap_or(0);
    let all_bytes: u64 = inside.iter().map(bytes).sum();
    assert_eq!(portions.iter().map(bytes).sum::<u64>(), all_bytes, "{schedule}");
    let dispatches =
        |passes: &[&PassRecord]| passes.iter().map(|pass| pass.dispatches).sum::<u32>();
    assert_eq!(dispatches(&portions), dispatches(&inside), "{schedule}");
    let invocations = |pass: &PassRecord| pass.invocations.or(Some(0));
    assert_eq!(sum(&portions, invocations), sum(&inside, invocations), "{schedule}");
    let counts = bench.solver.capabilities().unwrap().statistics.is_ok();
    assert!(portions.iter().all(|pass| pass.invocations.is_some() == counts), "{schedule}");
    for portion in portions {
        assert!(portion.nanoseconds.is_none_or(|time| time > 0), "{portion:?}");
        assert!(!portion.is_idle() && portion.iteration.is_none());
    }
}

/// Returns the number of iterations in records.
fn of_iterations(passes: &[PassRecord]) -> u32 {
    let counted = |pass: &&PassRecord| pass.kind == PassKind::Iteration && !pass.is_idle();
    passes.iter().filter(counted).count() as u32
}

/// Seven by four points are four by two texels. With planar fronts, each texel has 16 bytes of arrival times
/// that are read and 16 that are written, and four points with four edge lengths of 4 bytes. With curved
/// fronts, it has the same bytes again for the fronts' curvature, and 16 for the surface's. A point has two
/// triangles.
#[test]
fn bytes_agree_with_a_count_by_hand() {
    let mut bench = Bench::new(7, 4);
    for (wavefront, read, written) in
        [(Wavefront::Planar, 16 + 64, 16), (Wavefront::Curved, 32 + 64 + 16, 32)]
    {
        let profile = bench.profile(method(wavefront, Schedule::Raster), Detail::default());
        let scans: Vec<_> = profile
            .passes()
            .filter(|pass| matches!(pass.kind, PassKind::Scan(_) | PassKind::Pair(_)))
            .collect();
        let texels = sum(&scans, |pass| pass.work.texels);
        assert!(texels >= 8);
        assert_eq!(sum(&scans, |pass| pass.work.bytes_read), texels * read);
        assert_eq!(sum(&scans, |pass| pass.work.bytes_written), texels * written);
        assert_eq!(sum(&scans, |pass| pass.work.triangles), texels * 4 * 2);
        let unpack = of_kind(&profile, PassKind::Unpack).next().unwrap();
        assert_eq!((unpack.work.bytes_read, unpack.work.bytes_written), (Some(112), Some(112)));
    }
}

/// The progress has 924 numbers: 16 for the state of a map, one for each scan's blocks past the middle, six for each of
/// 128 rounds and for the next one, the largest change of each of 128 rounds, whether a point was reached, and how many
/// texels were settled. A tile has six numbers. For raster scans, each block has three numbers for each scan; a scan
/// has the blocks of the grid's longer side, and one more at each end. A count reads seven numbers and writes five, in
/// the last iteration one more; after the last iteration, it reads one.
#[test]
fn counts_and_starts_agree_with_a_count_by_hand() {
    let mut bench = Bench::new(61, 90);
    let texels = TexelChart::new(bench.surface.chart()).unwrap();
    let tile = bench.solver.tuning().on_grid(texels).tile as usize;
    let tiles = (61usize.div_ceil(tile) * 90usize.div_ceil(tile)) as u64;
    let mut seen = [false; 3];
    // A recording has several iterations. Their number depends on the tolerance, so that of some maps the last iterations
    // of a recording come after convergence.
    let mut profiles = Vec::new();
    for tolerance in [0.9, 0.1, 1e-2, 1e-4, 1e-6] {
        let method = method(Wavefront::Planar, Schedule::Raster).with_stop(Stop::within(tolerance));
        let profile = bench.profile(method, Detail::default());
        let last = bench.iterations(method) - 1;
        for pass in of_kind(&profile, PassKind::Count) {
            let place = (pass.iteration.unwrap().cmp(&last) as i8 + 1) as usize;
            seen[place] = true;
            let by_hand = [(4 * 7, 4 * 5), (4 * 7, 4 * (5 + 1)), (4, 0)][place];
            assert_eq!(moved(pass), Some(by_hand), "{pass:?}");
        }
        profiles.push(profile);
    }
    let profile = &profiles[0];
    let start = of_kind(profile, PassKind::Start).next().unwrap();
    let progress = 4 * (16 + 4 + 6 * (128 + 1) + 128 + 2);
    let lines = u64::from(bench.solver.tuning().scan_lines);
    let blocks = 4 * (45u64.div_ceil(lines) + 2);
    assert_eq!(moved(start), Some((0, progress + 4 * 6 * tiles + 4 * 3 * blocks)));
    assert_eq!(seen, [true; 3], "before the last iteration, at it, and beyond");
}

/// A tile is in the other image if the lists of rounds have it an odd number of times. The settling pass reads the
/// state of every tile, and copies back the texels of each such tile that lie on the grid, eight numbers each. Before
/// further rounds, the six numbers of the next list are copied. The numbers of the other 128 lists, all numbers after
/// them, and the round for which each tile is listed are written.
#[test]
fn settled_texels_are_those_in_the_other_image() {
    let mut bench = Bench::new(100, 131);
    // In the corridors of a maze, fronts need more rounds than a recording has.
    bench.surface = Builtin::Maze.surface(100, 131).unwrap();
    bench.on_device = bench.solver.upload(&bench.surface).unwrap();
    bench.seeds = seeds_at(&bench.surface, (0, 0));
    let tile = bench.solver.tuning().tile as usize / 2;
    let (height, width) = (50, 66);
    let (down, across) = (50usize.div_ceil(tile), 66usize.div_ceil(tile));
    let detail = Detail { tiles: true, ..Detail::default() };
    let profile = bench.profile(method(Wavefront::Curved, Schedule::Tiles), detail);
    let (mut settled, mut beyond) = (0, 0);
    for submission in &profile.submissions {
        let mut in_other = vec![false; down * across];
        for &number in submission.tiles.iter().flatten() {
            in_other[number as usize] ^= true;
        }
        let texels = |number: usize| {
            let (row, col) = (tile * (number / across), tile * (number % across));
            (tile.min(height - row) * tile.min(width - col)) as u64
        };
        let tiles: Vec<_> = (0..down * across).filter(|&number| in_other[number]).collect();
        let texels: u64 = tiles.iter().map(|&number| texels(number)).sum();
        settled += texels;
        beyond += (tiles.len() * tile * tile) as u64 - texels;
        let by_hand = 4 * (down * across) as u64 + 2 * 16 * texels;
        for pass in &submission.passes {
            match pass.kind {
                PassKind::Settle => assert_eq!(moved(pass), Some((by_hand, by_hand))),
                PassKind::Resume => {
                    let written = 4 * (6 * (1 + 128) + 128 + 2 + down * across) as u64;
                    assert_eq!(moved(pass), Some((4 * 6, written)));
                }
                _ => {}
            }
        }
    }
    assert!(settled > 0 && beyond > 0);
    assert!(of_kind(&profile, PassKind::Resume).count() > 0);
}

/// Returns the bytes that were read and written.
fn moved(pass: &PassRecord) -> Option<(u64, u64)> {
    pass.work.bytes_read.zip(pass.work.bytes_written)
}

/// The device's own count of invocations gives the number of groups that have run, whatever was planned.
#[test]
fn the_device_counts_the_invocations_of_the_groups_in_the_records() {
    let mut bench = Bench::new(70, 131);
    let tuning = bench.solver.tuning();
    let counts = bench.solver.capabilities().unwrap().statistics.is_ok();
    let detail = Detail { grain: Grain::Blocks, invocations: true, tiles: true, whole: true };
    for (schedule, group) in
        [(Schedule::Raster, tuning.scan_width), (Schedule::Tiles, tuning.tile / 2 * 4)]
    {
        let profile = bench.profile(method(Wavefront::Circular, schedule), detail);
        let mut counted = 0;
        for pass in profile.passes() {
            let group = match pass.kind {
                PassKind::Scan(_) | PassKind::Pair(_) | PassKind::Tiles => Some(group),
                PassKind::Seed | PassKind::Unpack => Some(64),
                _ => None,
            };
            if let Some(group) = group {
                let groups: u32 = pass.groups.unwrap().iter().product();
                let invocations = u64::from(groups * group);
                assert_eq!(pass.invocations, counts.then_some(invocations), "{pass:?}");
                counted += usize::from(groups > 0);
            }
        }
        assert!(counted > 4, "{schedule}");
    }
}

/// Each list of tiles has as many tiles as its record, each tile once, and the first list contains the tile of the
/// source.
#[test]
fn tiles_are_listed_as_they_were_visited() {
    let mut bench = Bench::new(100, 131);
    let detail = Detail { tiles: true, ..Detail::default() };
    let profile = bench.profile(method(Wavefront::Curved, Schedule::Tiles), detail);
    let tile = bench.solver.tuning().tile as usize;
    let across = 131usize.div_ceil(tile);
    let tiles = 100usize.div_ceil(tile) * across;
    let lists: Vec<_> = profile.submissions.iter().flat_map(|found| &found.tiles).collect();
    let rounds: Vec<_> = of_kind(&profile, PassKind::Tiles).collect();
    assert_eq!(lists.len(), rounds.len());
    let mut seen = vec![false; tiles];
    for (list, round) in lists.iter().zip(&rounds) {
        // A dispatch may have more groups, since tiles on the list may have waited for the next round.
        assert!(round.groups.unwrap()[0] as usize >= list.len());
        let texels = (tile * tile / 4 * list.len()) as u64;
        assert_eq!(round.work.texels, Some(texels));
        assert_eq!(round.work.skipped, Some((tile * tile / 4 * tiles) as u64 - texels));
        let mut sorted = (*list).clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), list.len());
        sorted.iter().for_each(|&number| seen[number as usize] = true);
    }
    assert!(seen.iter().all(|&seen| seen), "every tile is visited once at least");
    let (row, col) = some_point(&bench.surface);
    assert!(lists[0].contains(&((row / tile * across + col / tile) as u32)));
}
