//! Glues sides of the surface, as requested on the command line.

use std::error::Error;

use clap::ValueEnum;
use geosweep::Surface;
use geosweep::surface::{
    CompletedGrid, Gluing, GluingError, GridSide, LastLine, Layout, Seam, SurfaceError,
};

#[derive(clap::Args)]
pub struct GlueArgs {
    /// Sides of the grid that continue each other on a closed surface, so that distances pass from one to the other.
    /// Where two such sides are not the same line of the surface, the tool adds a line, which outputs leave out.
    /// Positions show whether they are the same line, and so do heights, metrics, masks and slownesses that differ.
    /// Lines where all are equal count as the same line; --wrap tells otherwise
    #[arg(long, value_name = "SIDES", help_heading = "Surface", conflicts_with_all = ["wrap", "layout"])]
    glue: Option<Glue>,
    /// The grid goes on from its last column, row or both to the first: the same as --glue columns, rows or both.
    /// `:repeated` tells that the last line is the first one again, and `:apart` that it is one step from it: columns from
    /// 0 to 350 degrees are apart, from 0 to 360 repeated
    #[arg(long, value_name = "SIDES[:repeated|:apart]", value_parser = wrap, help_heading = "Surface")]
    #[arg(conflicts_with = "layout")]
    wrap: Option<Wrap>,
    /// With --wrap columns or rows, glue in reverse order: the same as --glue flipped-columns or flipped-rows
    #[arg(long, help_heading = "Surface", requires = "wrap", conflicts_with = "poles")]
    flip: bool,
    /// With --wrap columns, the first and the last row are poles or surround them: --glue globe
    #[arg(long, help_heading = "Surface", requires = "wrap")]
    poles: bool,
    /// Map of a whole surface: --glue octahedral or cube
    #[arg(long, value_name = "MAP", help_heading = "Surface")]
    layout: Option<MapLayout>,
}

/// The sides of the grid that continue each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Glue {
    /// All sides that coincide or are neighbours, as the warning about closed surfaces lists them
    Auto,
    /// The last column continues in the first one: tubes and closed cones
    Columns,
    /// The last row continues in the first one
    Rows,
    /// Both: a torus
    Both,
    /// The last column continues in the first one in reverse order: a Moebius strip
    FlippedColumns,
    /// The last row continues in the first one in reverse order
    FlippedRows,
    /// Rows are latitudes from pole to pole, with rows at the poles or beside them, and the last column continues in
    /// the first one
    Globe,
    /// An octahedral map: the halves of each side coincide
    Octahedral,
    /// Charts that holes keep apart, such as the six faces of a cube with points on their edges
    Charts,
    /// Six faces of a cube with points at the middles of texels: 2 x 3, 3 x 2, 1 x 6, 6 x 1 or a cross, with or without
    /// a line of holes between them
    Cube,
}

/// The sign that the last line of a grid is the first one again.
#[derive(Clone, Copy, Debug)]
pub enum Last {
    Told(LastLine),
    /// The positions and values of the lines, unless they leave it open.
    Found,
    /// As [`Self::Found`], and lines of equal values are the same: sides that are glued are one line.
    SameIfEqual,
}

/// Opposite sides that continue each other, and whether the last line is the first one again, if that is said.
#[derive(Clone, Copy, Debug)]
struct Wrap {
    sides: Wrapped,
    last: Option<LastLine>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrapped {
    Columns,
    Rows,
    Both,
}

fn wrap(text: &str) -> Result<Wrap, String> {
    let form = || "choose columns, rows or both, and after it :repeated or :apart".to_string();
    let (sides, last) = text.split_once(':').map_or((text, None), |(a, b)| (a, Some(b)));
    let sides = match sides {
        "columns" | "cols" => Wrapped::Columns,
        "rows" => Wrapped::Rows,
        "both" => Wrapped::Both,
        _ => return Err(form()),
    };
    let last = match last {
        None => None,
        Some("repeated") => Some(LastLine::Repeats),
        Some("apart") => Some(LastLine::IsApart),
        Some(_) => return Err(form()),
    };
    Ok(Wrap { sides, last })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MapLayout {
    /// An octahedral map with points on its sides
    Octahedral,
    /// Six faces of a cube with points at the middles of texels
    Cube,
}

impl GlueArgs {
    /// Returns the requested gluing, given by any of its names, and whether the last line is the first one again.
    pub fn wanted(&self) -> Result<Option<(Glue, Last)>, String> {
        let last = match self.wrap {
            None => Last::SameIfEqual,
            Some(Wrap { last: None, .. }) => Last::Found,
            Some(Wrap { last: Some(last), .. }) => Last::Told(last),
        };
        Ok(self.glue()?.map(|glue| (glue, last)))
    }

    fn glue(&self) -> Result<Option<Glue>, String> {
        let of_layout = self.layout.map(|layout| match layout {
            MapLayout::Octahedral => Glue::Octahedral,
            MapLayout::Cube => Glue::Cube,
        });
        let Some(wrap) = self.wrap else { return Ok(self.glue.or(of_layout)) };
        Ok(Some(match (wrap.sides, self.flip, self.poles) {
            (Wrapped::Columns, false, false) => Glue::Columns,
            (Wrapped::Columns, true, _) => Glue::FlippedColumns,
            (Wrapped::Columns, false, true) => Glue::Globe,
            (Wrapped::Rows, false, false) => Glue::Rows,
            (Wrapped::Rows, true, false) => Glue::FlippedRows,
            (Wrapped::Both, false, false) => Glue::Both,
            (_, _, true) => {
                return Err("--poles is for --wrap columns, where rows are latitudes".into());
            }
            (Wrapped::Both, true, false) => {
                return Err(
                    "--flip is for --wrap columns or rows; with --wrap both, sides cannot be flipped".into()
                );
            }
        }))
    }
}

/// A surface whose sides are glued.
pub struct Whole {
    pub surface: Surface,
    /// The surface with the positions, if it is separate and lines have been added to it.
    pub shape: Option<Surface>,
    /// The lines of the grid, if some have been added.
    pub lines: Option<CompletedGrid>,
    /// Whether the last column continues in the first one.
    pub goes_round: bool,
}

impl Glue {
    /// Glues a surface, and adds the lines that its grid lacks. `shape` is the surface with the positions, if it is
    /// separate. `seams` are the sides that coincide or are neighbours.
    pub fn apply(
        self,
        surface: Surface,
        shape: Option<&Surface>,
        seams: &[Seam],
        last: Last,
    ) -> Result<Whole, Box<dyn Error>> {
        let name = self.to_possible_value().map(|value| value.get_name().to_owned());
        let name = name.unwrap_or_default();
        let whole = self.whole(surface, shape, seams, last);
        Ok(whole.map_err(|error| format!("--glue {name}: {error}"))?)
    }

    fn whole(
        self,
        surface: Surface,
        shape: Option<&Surface>,
        seams: &[Seam],
        last: Last,
    ) -> Result<Whole, Box<dyn Error>> {
        if surface.is_glued() {
            return self.keep(surface);
        }
        let gluing = match self.layout() {
            None => match self {
                Self::Octahedral => Gluing::Octahedral,
                Self::Charts => Gluing::Charts,
                _ => {
                    note_lacking_poles(shape.unwrap_or(&surface), seams);
                    Gluing::Seams(found(seams)?)
                }
            },
            Some(layout) => {
                let told = shape.unwrap_or(&surface);
                let lines = match last {
                    Last::Told(last) => CompletedGrid::with_last_line(told, layout, last)?,
                    Last::Found => CompletedGrid::new(told, layout)?,
                    Last::SameIfEqual => match CompletedGrid::new(told, layout) {
                        Err(SurfaceError::Gluing(GluingError::Unclear { sides })) => {
                            note!(
                                "the {} and the {} hold the same values and count as one line; --wrap \
                                 columns:apart or rows:apart tells that they are one step apart",
                                sides[0],
                                sides[1]
                            );
                            CompletedGrid::with_last_line(told, layout, LastLine::Repeats)?
                        }
                        lines => lines?,
                    },
                };
                return self.completed(surface, shape, lines);
            }
        };
        match &gluing {
            Gluing::Seams(seams)
                if seams.iter().any(|seam| matches!(seam, Seam::Neighbours { .. })) =>
            {
                let lines = CompletedGrid::with_seams(surface.chart(), seams)?;
                self.completed(surface, shape, lines)
            }
            _ => Ok(Whole {
                surface: surface.with_gluing(gluing)?,
                shape: None,
                lines: None,
                goes_round: false,
            }),
        }
    }

    /// Returns a surface that is glued already, if it is by this gluing.
    fn keep(self, surface: Surface) -> Result<Whole, Box<dyn Error>> {
        let gluing = match self {
            Self::Auto => None,
            Self::Columns => Some(Gluing::columns()),
            Self::Rows => Some(Gluing::rows()),
            Self::Both => Some(Gluing::both()),
            Self::FlippedColumns => Some(Gluing::flipped_columns()),
            Self::FlippedRows => Some(Gluing::flipped_rows()),
            Self::Globe => Some(Gluing::globe()),
            Self::Octahedral => Some(Gluing::Octahedral),
            Self::Charts | Self::Cube => Some(Gluing::Charts),
        };
        match gluing.is_none_or(|gluing| surface.is_glued_by(&gluing)) {
            true => Ok(Whole { surface, shape: None, lines: None, goes_round: false }),
            false => {
                Err("the built-in surface is closed already, along other sides; leave --glue out"
                    .into())
            }
        }
    }

    /// Adds the lines that a surface's grid lacks, and glues the surface.
    fn completed(
        self,
        surface: Surface,
        shape: Option<&Surface>,
        lines: CompletedGrid,
    ) -> Result<Whole, Box<dyn Error>> {
        if !lines.is_extended() {
            let surface = surface.with_gluing(lines.gluing().clone())?;
            return Ok(Whole { surface, shape: None, lines: None, goes_round: false });
        }
        let whole = lines.complete(&surface)?;
        let shape = shape.map(|shape| lines.complete(shape)).transpose()?;
        let (given, chart) = (lines.given(), lines.chart());
        note!(
            "the grid of {} x {} points does not repeat the samples of its seams; the surface has {} x {}, and \
                 outputs have those of the grid",
            given.rows,
            given.cols,
            chart.rows,
            chart.cols
        );
        let goes_round = match lines.gluing() {
            Gluing::Seams(seams) => seams.contains(&COLUMNS),
            _ => false,
        };
        Ok(Whole { surface: whole, shape, lines: Some(lines), goes_round })
    }

    /// Returns the layout by which [`CompletedGrid`] finds the missing lines, if this gluing has one.
    fn layout(self) -> Option<Layout> {
        Some(match self {
            Self::Columns => Layout::Columns,
            Self::Rows => Layout::Rows,
            Self::Both => Layout::Both,
            Self::FlippedColumns => Layout::FlippedColumns,
            Self::FlippedRows => Layout::FlippedRows,
            Self::Globe => Layout::Globe,
            Self::Cube => Layout::Cube,
            Self::Auto | Self::Octahedral | Self::Charts => return None,
        })
    }
}

/// The seam that joins the last column to the first one.
const COLUMNS: Seam =
    Seam::Sides { sides: [GridSide::FirstColumn, GridSide::LastColumn], reversed: false };

/// Prints a note if the grid may be a globe without its poles. A tube that narrows at both ends looks the same, so
/// poles are added only on request.
fn note_lacking_poles(surface: &Surface, seams: &[Seam]) {
    let goes_round = |seam: &Seam| {
        let sides = [GridSide::FirstColumn, GridSide::LastColumn];
        [Seam::Sides { sides, reversed: false }, Seam::Neighbours { sides, reversed: false }]
            .contains(seam)
    };
    let lacks = |grid: &CompletedGrid| grid.chart().rows > surface.rows();
    if seams.iter().any(goes_round)
        && CompletedGrid::new(surface, Layout::Globe).is_ok_and(|grid| lacks(&grid))
    {
        note!(
            "the first and the last row may surround poles that the grid lacks: no path crosses them; --glue globe adds \
             them"
        );
    }
}

/// Returns the seams as a list, or an error if there are none.
fn found(seams: &[Seam]) -> Result<Vec<Seam>, Box<dyn Error>> {
    match seams {
        [] => Err("no sides of the grid coincide or are neighbours; leave --glue out, or name the sides to see how \
                   far they are apart"
            .into()),
        seams => Ok(seams.to_vec()),
    }
}
