//! Options of what the surface shows. Keys switch them, and they stay from one surface to the next.

use crate::agents::Steps;
use crate::decal::{Look, Placement, RADIUS};
use crate::options::Options;

/// The reason why closed surfaces do not show everything.
pub const NO_SEAMS: &str = "do not pass seams yet";

#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Whether lines of equal distance are drawn as curves.
    pub contours: bool,
    pub decal: Look,
    agents: bool,
    /// Whether a path was requested on a closed surface.
    pub lacks_path: bool,
    /// Rule by which agents step, also while they are hidden.
    steps: Steps,
}

impl Shown {
    /// Returns the part of this that a surface shows. Agents and decals do not pass seams, so closed surfaces show
    /// none.
    pub fn on(&self, is_closed: bool) -> Self {
        match is_closed {
            true => Self { agents: false, decal: Look { placement: None, ..self.decal }, ..*self },
            false => *self,
        }
    }

    /// Returns the initial options.
    pub fn new(options: &Options) -> Self {
        let decal = Look { placement: options.decal, radius: RADIUS };
        let steps = if options.neighbours { Steps::Neighbours } else { Steps::Directions };
        Self { contours: false, decal, agents: options.agents, lacks_path: false, steps }
    }

    /// Returns how agents step; `None` while they are hidden.
    pub fn steps(&self) -> Option<Steps> {
        self.agents.then_some(self.steps)
    }

    pub fn switch_contours(&mut self) {
        self.contours = !self.contours;
    }

    pub fn switch_agents(&mut self) {
        self.agents = !self.agents;
    }

    pub fn switch_steps(&mut self) {
        self.steps = match self.steps {
            Steps::Directions => Steps::Neighbours,
            Steps::Neighbours => Steps::Directions,
        };
    }

    pub fn next_decal(&mut self) {
        self.decal = self.decal.placed_otherwise();
    }

    pub fn enlarge_decal(&mut self) {
        self.decal = self.decal.larger(1);
    }

    pub fn shrink_decal(&mut self) {
        self.decal = self.decal.larger(-1);
    }

    /// Returns the part of the window's title that tells what is shown on a surface, and what cannot be.
    pub fn title(&self, is_closed: bool) -> String {
        match is_closed {
            true => self.on(is_closed).title_of_all() + &self.refused(),
            false => self.title_of_all(),
        }
    }

    /// Returns what was requested and is not possible on a closed surface.
    fn refused(&self) -> String {
        let agents = self.agents.then_some("agents");
        let decals = self.decal.placement.map(|_| "decals");
        let asked = [agents, decals, self.lacks_path.then_some("paths")];
        let refused = asked.into_iter().flatten();
        refused.map(|what| format!(", {what} {NO_SEAMS}")).collect()
    }

    fn title_of_all(&self) -> String {
        let contours = if self.contours { ", contours as lines" } else { "" };
        let agents = match self.steps() {
            None => "",
            Some(Steps::Directions) => ", agents along directions",
            Some(Steps::Neighbours) => ", agents to neighbours",
        };
        let decal = match self.decal.placement {
            None => "",
            Some(Placement::LogMap) => ", decal by the log map",
            Some(Placement::Projected) => ", decal from above",
        };
        format!("{contours}{agents}{decal}")
    }
}
